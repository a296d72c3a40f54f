"""A Ray cluster of a head and two nodes of one core; run as a program with the port for clients.

It prints a line when the cluster is up, loses a node for each line on standard input, and ends at its end.
"""

from __future__ import annotations

import sys

from ray.cluster_utils import Cluster

STORE_BYTES = 100 * 2**20


def main() -> None:
    store = {"object_store_memory": STORE_BYTES}
    head = {"num_cpus": 0, "include_dashboard": False, "ray_client_server_port": int(sys.argv[1]), **store}
    cluster = Cluster(initialize_head=True, head_node_args=head)
    nodes = [cluster.add_node(num_cpus=1, **store) for _ in range(2)]
    print("up", flush=True)
    for _ in sys.stdin:
        cluster.remove_node(nodes.pop(), allow_graceful=False)
    cluster.shutdown()


if __name__ == "__main__":
    main()
