const int kuwahara_orientations = 32, kuwahara_anisotropies = 8, kuwahara_sectors = 8;

// Means of eight sectors of an ellipse along the flow, each weighted by how even it is. Kyprianidis et al. 2009, 2010.
vec3 kuwahara(ivec2 at, vec3 flow, float radius, float stretch, int sharpness) {
    vec2 twice = 2.0 * flow.xy - 1.0;
    float clearness = length(twice) / max(flow.z, 1e-6);
    float shape = floor(clamp(clearness * float(kuwahara_anisotropies), 0.0, float(kuwahara_anisotropies - 1)));
    float turns = twice == vec2(0.0) ? 0.0 : atan(twice.y, twice.x) * float(kuwahara_orientations) / 6.283185307;
    float angle = 3.141592654 * (floor(turns + 0.5) / float(kuwahara_orientations) + 0.5);
    float longer = 1.0 + stretch * (shape + 0.5) / float(kuwahara_anisotropies);
    vec2 axis = vec2(cos(angle), sin(angle)), sides = vec2(radius * longer, radius / longer);
    float lift = 2.0 / radius, crossing = sin(0.58), narrowness = (lift + cos(0.58)) / (crossing * crossing);
    vec3 means[kuwahara_sectors];
    float squares[kuwahara_sectors], weights[kuwahara_sectors];
    for (int sector = 0; sector < kuwahara_sectors; sector++) {
        means[sector] = vec3(0.0);
        squares[sector] = weights[sector] = 0.0;
    }
    int reach = int(ceil(radius * (1.0 + stretch)));
    for (int row = -reach; row <= reach; row++) {
        for (int column = -reach; column <= reach; column++) {
            vec2 away = vec2(column, row);
            vec2 place = vec2(dot(axis, away), axis.x * away.y - axis.y * away.x) / sides;
            float squared = dot(place, place);
            if (squared <= 1.0) {
                float own[kuwahara_sectors], total = 0.0;
                for (int sector = 0; sector < kuwahara_sectors; sector++) {
                    float turn = 0.7853981634 * float(sector), cosine = cos(turn), sine = sin(turn);
                    float ahead = cosine * place.x + sine * place.y, aside = cosine * place.y - sine * place.x;
                    float weight = max(ahead + lift - narrowness * aside * aside, 0.0);
                    own[sector] = weight * weight;
                    total += own[sector];
                }
                vec3 value = picture_at(at + ivec2(column, row));
                float share = exp(-3.125 * squared) / total, square = dot(value, value);
                for (int sector = 0; sector < kuwahara_sectors; sector++) {
                    float weight = own[sector] * share;
                    means[sector] += weight * value;
                    squares[sector] += weight * square;
                    weights[sector] += weight;
                }
            }
        }
    }
    vec3 sum = vec3(0.0);
    float shares = 0.0;
    for (int sector = 0; sector < kuwahara_sectors; sector++) {
        vec3 mean = means[sector] / weights[sector];
        float variance = 255.0 * abs(squares[sector] / weights[sector] - dot(mean, mean));
        for (int each = 0; each < sharpness; each++)
            variance *= variance;
        float share = 1.0 / (1.0 + variance);
        sum += share * mean;
        shares += share;
    }
    return sum / shares;
}
