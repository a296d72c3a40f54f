// The linear light of sRGB values.
vec3 light_of(vec3 value) {
    vec3 curved = pow((value + 0.055) / 1.055, vec3(2.4));
    return mix(curved, value / 12.92, lessThanEqual(value, vec3(0.04045)));
}

// OKLab of an sRGB colour. Ottosson 2020.
vec3 oklab(vec3 color) {
    vec3 cones = light_of(color) * mat3(
        0.4122214708, 0.5363325363, 0.0514459929, 0.2119034982, 0.6806995451, 0.1073969566, 0.0883024619,
        0.2817188376, 0.6299787005);
    return pow(max(cones, 1e-12), vec3(1.0 / 3.0)) * mat3(
        0.2104542553, 0.7936177850, -0.0040720468, 1.9779984951, -2.4285922050, 0.4505937099, 0.0259040371,
        0.7827717662, -0.8086757660);
}

// The nearest colour of a palette in OKLab, the first one for ties. Rows of the table: OKLab, then RGB.
vec3 palette(vec3 picture, sampler2DArray colors, ivec2 colors_size) {
    vec3 lab = oklab(clamp(picture + 5e-5, 0.0, 1.0));
    int nearest = 0;
    float least = 1e9;
    for (int number = 0; number < colors_size.x; number++) {
        vec3 away = lab;
        for (int row = 0; row < 3; row++)
            away[row] -= texelFetch(colors, ivec3(number, row, 0), 0).r;
        float distance_squared = dot(away, away);
        nearest = distance_squared < least ? number : nearest;
        least = min(distance_squared, least);
    }
    vec3 color;
    for (int row = 0; row < 3; row++)
        color[row] = texelFetch(colors, ivec3(nearest, row + 3, 0), 0).r;
    return color;
}
