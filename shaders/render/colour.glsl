// The colour of a body or of its field. Linear.
layout(binding = 1) uniform sampler1D field_colours; // linear

vec3 surface_colour(vec3 own, float value) {
  if (field.z == 0.0) return own;
  float share = clamp((value - field.x) * field.y, 0.0, 1.0);
  if (isnan(value)) return vec3(0.5, 0.0, 0.35);
  return textureLod(field_colours, (share * 255.0 + 0.5) / 256.0, 0.0).rgb;
}
