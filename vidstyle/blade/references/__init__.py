"""The reference filters that the shipped banks approximate: written for clarity, not speed.

All take luma, H x W, 0..1 and gamma-encoded like video, and return new H x W float32. Lengths are in pixels;
the border is repeated. They commute with rotations and reflections, as do banks trained on all eight
symmetries.
"""

from vidstyle.blade.references.detail_base import detail_base
from vidstyle.blade.references.edge_flow import edge_tangent_flow, flow_dog_parts
from vidstyle.blade.references.second_order_flow import second_order_tv_flow
from vidstyle.blade.references.tv_flow import tv_flow

__all__ = ["detail_base", "edge_tangent_flow", "flow_dog_parts", "second_order_tv_flow", "tv_flow"]
