// The neighbourhood of a work group in shared memory, so that each pixel is read from the texture once.
shared VALUE around[AROUND_ROOM];
ivec2 group_first, group_size, around_first, around_size;

void load_around(ivec2 first, ivec2 size) {
    group_first = first;
    group_size = size;
    around_first = first - around_radius;
    around_size = size + 2 * around_radius;
    ivec2 own = ivec2(gl_LocalInvocationID.xy), next = ivec2(gl_WorkGroupSize.xy);
    for (int y = own.y; y < around_size.y; y += next.y) {
        for (int x = own.x; x < around_size.x; x += next.x) {
            around[y * around_size.x + x] = IMAGE_at(around_first + ivec2(x, y));
        }
    }
    barrier();
}

VALUE picture_at(ivec2 at) {
    ivec2 inside = at - around_first;
    return around[inside.y * around_size.x + inside.x];
}
