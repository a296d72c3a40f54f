// A pixel filtered with the filter selected for it. The bank holds, for each pair of opposite pixels, the
// weight of their sum minus twice the middle, and, if filters are not symmetric, then the weights of their
// differences; `part_sums` are the responses of the parts to a constant 1. If each filter has its own sum, the next
// texel holds it and the constants to add. The weights of differences that are limited by each of `clips` come last.
channels filtered(ivec2 at, float chosen, sampler2DArray bank, int bank_count, int size, int clip_count,
        float clips[3], float part_weights[8], float part_sums[8], float identity) {
    int number = clamp(int(chosen * 1024.0 + 0.5), 0, textureSize(bank, 0).y - 1);
    int radius = size / 2, pair = 0;
    int texels = (size * size - 1) / 8, count = textureSize(bank, 0).x - clip_count * texels;
    bool is_symmetric = count == texels;
    channels middle = picture_at(at), total = identity * middle;
    vec4 weights = vec4(0.0), differences = vec4(0.0);
    for (int part = 0; part < bank_count; part++) {
        total += part_weights[part] * part_sums[part] * middle;
        if (count > 2 * texels) {
            vec4 line = texelFetch(bank, ivec3(2 * texels, number, part), 0);
            total += part_weights[part] * (line.x * middle + channels(line.yzww));
        }
    }
    for (int down = 0; down <= radius; down++) {
        for (int right = down == 0 ? 1 : -radius; right <= radius; right++) {
            ivec2 there = ivec2(right, down);
            if ((pair & 3) == 0) {
                weights = differences = vec4(0.0);
                for (int part = 0; part < bank_count; part++) {
                    ivec3 place = ivec3(pair / 4, number, part);
                    weights += part_weights[part] * texelFetch(bank, place, 0);
                    if (!is_symmetric) {
                        differences += part_weights[part] * texelFetch(bank, place + ivec3(texels, 0, 0), 0);
                    }
                }
            }
            channels one = picture_at(at + there), other = picture_at(at - there);
            total += weights.x * (one + other - 2.0 * middle) + differences.x * (one - other);
            weights = weights.yzww;
            differences = differences.yzww;
            pair++;
        }
    }
    for (int clip = 0; clip < clip_count; clip++) {
        pair = 0;
        channels limit = channels(clips[clip]);
        for (int down = 0; down <= radius; down++) {
            for (int right = down == 0 ? 1 : -radius; right <= radius; right++) {
                ivec2 there = ivec2(right, down);
                if ((pair & 3) == 0) {
                    weights = vec4(0.0);
                    for (int part = 0; part < bank_count; part++) {
                        ivec3 place = ivec3(count + clip * texels + pair / 4, number, part);
                        weights += part_weights[part] * texelFetch(bank, place, 0);
                    }
                }
                channels one = picture_at(at + there) - middle, other = picture_at(at - there) - middle;
                total += weights.x * (clamp(one, -limit, limit) + clamp(other, -limit, limit));
                weights = weights.yzww;
                pair++;
            }
        }
    }
    return total;
}
