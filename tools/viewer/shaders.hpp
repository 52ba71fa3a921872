#pragma once

// GLSL 3.30. Colours are given as sRGB, and lighting is computed with linear values. Bright colours are compressed
// towards white, as tetrakis::render() does.
namespace tetrakis::viewer {

inline constexpr const char* k_colour_functions = R"(#version 330 core
vec3 linear(vec3 srgb) { return pow((srgb + 0.055) / 1.055, vec3(2.4)); }
vec3 shown(vec3 light) {
    light = mix(light, 1 - 0.3 * exp((0.7 - light) / 0.3), greaterThan(light, vec3(0.7)));
    return mix(1.055 * pow(light, vec3(1 / 2.4)) - 0.055, 12.92 * light, lessThan(light, vec3(0.0031308)));
}
)";

// Places a vertex as lod::shown_position() does.
inline constexpr const char* k_ground_vertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 on_edge;
layout(location = 2) in vec2 octahedral;  // from -32767 to 32767
layout(location = 3) in float error;
uniform mat4 projection;  // of places relative to the eye
uniform vec3 eye, morph_eye;
uniform float morph_scale, morph_begin;
centroid out vec3 normal, to_eye;
void main() {
    float ratio = error > 0 ? distance(position, morph_eye) / (error * morph_scale) : 1;
    float on_edge_share = clamp((ratio - morph_begin) / (1 - morph_begin), 0, 1);
    to_eye = eye - mix(position, on_edge, on_edge_share);
    gl_Position = projection * vec4(-to_eye, 1);
    vec2 n = octahedral / 32767;
    float z = 1 - abs(n.x) - abs(n.y);
    if (z < 0) n = (1 - abs(n.yx)) * vec2(n.x < 0 ? -1 : 1, n.y < 0 ? -1 : 1);
    normal = vec3(n, z);
}
)";

// The lighting of tetrakis::render(), without shadows, occlusion and the key light's highlight.
inline constexpr const char* k_ground_fragment = R"(
centroid in vec3 normal, to_eye;
uniform vec3 key, fill, rim, up, surface_colour, wire_colour;
uniform bool wire;
out vec4 colour;
void main() {
    vec3 n = normalize(normal);
    vec3 warm = vec3(1, 0.965, 0.91), cool = vec3(0.86, 0.93, 1);
    float from_fill = max(0, (dot(n, fill) + 0.3) / 1.3), from_sky = 0.62 + 0.38 * dot(n, up);
    vec3 light = 2.65 / 3.14159265 * max(0, dot(n, key)) * warm + (0.42 / 1.6 * from_fill + 0.6 * from_sky) * cool;
    float grazing = pow(1 - max(0, dot(n, normalize(to_eye))), 5);
    vec3 edge = grazing * (0.55 * max(0, dot(n, rim)) + 0.16 * max(0, from_sky)) * cool;
    colour = vec4(wire ? wire_colour : shown(linear(surface_colour) * light + edge), 1);
}
)";

inline constexpr const char* k_sky_vertex = R"(#version 330 core
out float down;
void main() {  // one triangle that covers the viewport
    vec2 at = vec2(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1);
    down = 0.5 - 0.5 * at.y;
    gl_Position = vec4(at, 1, 1);
}
)";

inline constexpr const char* k_sky_fragment = R"(
in float down;
uniform vec3 top_colour, bottom_colour;
out vec4 colour;
void main() { colour = vec4(shown(mix(linear(top_colour), linear(bottom_colour), smoothstep(0, 1, down))), 1); }
)";

}  // namespace tetrakis::viewer
