// Shadow maps, for comparison: what a client without masks would do. The share of a light that reaches a point, from
// maps of the depths that the light sees (shadow_maps.js).
export const MAPS = `
uniform sampler2DArrayShadow shadow_maps;
uniform sampler2D map_records;  // of each layer: the columns of its matrix, the width of a texel, the matrix' origin

float share_in_layer(int layer, vec3 point, vec3 off, float distance_to_light) {
  mat4 to_clip = mat4(texelFetch(map_records, ivec2(0, layer), 0), texelFetch(map_records, ivec2(1, layer), 0),
                      texelFetch(map_records, ivec2(2, layer), 0), texelFetch(map_records, ivec2(3, layer), 0));
  vec4 size = texelFetch(map_records, ivec2(4, layer), 0);
  // Off the surface by about a texel, the more the flatter the light falls, so that the surface does not shade itself.
  float texel = size.x + size.y * distance_to_light;
  vec3 origin = texelFetch(map_records, ivec2(5, layer), 0).xyz;
  vec4 clip = to_clip * vec4(point - origin + off * texel, 1.0);
  vec3 place = clip.xyz / clip.w * 0.5 + 0.5;
  if (clip.w <= 0.0 || any(lessThan(place, vec3(0.0))) || any(greaterThan(place, vec3(1.0)))) return 1.0;
  return texture(shadow_maps, vec4(place.xy, float(layer), place.z));
}

float share_by_map(int i, TracedLight light, SurfacePoint surface) {
  int layer = int(texelFetch(lights, ivec2(3, i), 0).w);
  if (layer < 0) return 1.0;
  vec3 away = surface.position - light.position;
  float facing = light.kind == 2u ? dot(surface.normal, light.direction) : dot(surface.normal, normalize(away));
  vec3 off = surface.normal * sqrt(max(1.0 - facing * facing, 0.0));
  if (light.kind == 0u) {
    vec3 size = abs(away);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    layer += 2 * axis + (away[axis] < 0.0 ? 1 : 0);
    return share_in_layer(layer, surface.position, off, size[axis]);
  }
  return share_in_layer(layer, surface.position, off, dot(away, light.direction));
}
`;
