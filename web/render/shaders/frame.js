// gpu/shaders/frame.glsl and surface.glsl: the view, the scene's lists and the alpha test. Lists lie in textures, row by
// row, ROW_BITS wide.
export const SCENE = `
uniform sampler2D vertices;     // position, u
uniform sampler2D normals;      // normal, v
uniform usampler2D triangles;   // three corners, material
uniform sampler2D records;      // of materials, then of the levels of textures

ivec2 place_in_list(uint i) { return ivec2(int(i & ((1u << ROW_BITS) - 1u)), int(i >> ROW_BITS)); }
uvec4 triangle_of(uint triangle) { return texelFetch(triangles, place_in_list(triangle), 0); }
vec3 position_of(uint vertex) { return texelFetch(vertices, place_in_list(vertex), 0).xyz; }
vec3 normal_of(uint vertex) { return texelFetch(normals, place_in_list(vertex), 0).xyz; }
vec2 uv_of(uint vertex) {
  return vec2(texelFetch(vertices, place_in_list(vertex), 0).w, texelFetch(normals, place_in_list(vertex), 0).w);
}

struct MaterialRecord {
  vec4 base_color;
  vec3 emissive;
  float alpha_cutoff;
  bool textured;
  ivec2 texture_size;
  ivec2 wrap;        // 0 repeat, 1 mirrored, 2 clamp
  uint first_level;  // its record
  int levels;
};

MaterialRecord material_of(uint material) {
  vec4 base = texelFetch(records, place_in_list(4u * material), 0);
  vec4 glow = texelFetch(records, place_in_list(4u * material + 1u), 0);
  vec4 size = texelFetch(records, place_in_list(4u * material + 2u), 0);
  vec4 wraps = texelFetch(records, place_in_list(4u * material + 3u), 0);
  return MaterialRecord(base, glow.xyz, glow.w, size.z > 0.0, ivec2(size.xy), ivec2(wraps.xy), uint(size.w),
                        int(size.z));
}
`;

export const VIEW = `
uniform vec3 camera;
uniform vec3 forward;
uniform vec3 ray_corner;
uniform vec3 ray_dx;
uniform vec3 ray_dy;

// The ray through the centre of the pixel; its component along \`forward\` is 1.
vec3 pixel_ray(ivec2 pixel) {
  return ray_corner + (float(pixel.x) + 0.5) * ray_dx + (float(pixel.y) + 0.5) * ray_dy;
}

SurfacePoint surface_of(uvec4 corners, ivec2 pixel) {
  return surface_point(camera, forward, pixel_ray(pixel), position_of(corners.x), position_of(corners.y),
                       position_of(corners.z));
}
`;

// Nearest texel of level 0: the same rule as scenes::passes_alpha_test.
export const ALPHA = `
uniform sampler2DArray texels;  // each colour as its square root

int wrap_texel(float u, int wrap, int size) {
  float within_two = u - 2.0 * floor(0.5 * u);
  float repeated = u - floor(u);
  float mirrored = within_two > 1.0 ? 2.0 - within_two : within_two;
  float at = wrap == 2 ? clamp(u, 0.0, 1.0) : wrap == 0 ? repeated : mirrored;
  return min(int(at * float(size)), size - 1);
}

bool passes_alpha_test(MaterialRecord m, vec2 uv) {
  float alpha = m.base_color.a;
  if (m.textured) {
    ivec3 level = ivec3(texelFetch(records, place_in_list(m.first_level), 0).xyz);
    ivec2 texel = ivec2(wrap_texel(uv.x, m.wrap.x, m.texture_size.x), wrap_texel(uv.y, m.wrap.y, m.texture_size.y));
    alpha *= texelFetch(texels, ivec3(level.xy + texel, level.z), 0).a;
  }
  return alpha >= m.alpha_cutoff;
}
`;
