"""The reference filters that the shipped banks approximate: slow, and written for clarity.

All take luma, H x W, 0..1 and gamma-encoded as video is, and return new H x W float32; lengths are in pixels,
the border is repeated. They commute with turns and mirroring, as does a bank that learns from all eight.
"""

from vidstyle.blade.references.detail_base import detail_base
from vidstyle.blade.references.edge_flow import edge_tangent_flow, flow_dog_parts
from vidstyle.blade.references.second_order_flow import second_order_tv_flow
from vidstyle.blade.references.tv_flow import tv_flow

__all__ = ["detail_base", "edge_tangent_flow", "flow_dog_parts", "second_order_tv_flow", "tv_flow"]
