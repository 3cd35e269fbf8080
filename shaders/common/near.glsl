// Differences of places where a domain repeats: the shortest of their images.
float shortest(float d, float period) { return period > 0.0 ? d - period * round(d / period) : d; }
vec3 shortest(vec3 d, vec3 period) {
  return vec3(shortest(d.x, period.x), shortest(d.y, period.y), shortest(d.z, period.z));
}
