// From i to j where both are in one place: any direction will do that both agree on.
vec3 agreed_direction(uint i, uint j) {
  uint h = min(i, j) * 2654435761u ^ max(i, j) * 2246822519u;
  h ^= h >> 15;
  h *= 739982445u;
  h ^= h >> 12;
  vec3 d = vec3(float(h & 1023u), float((h >> 10) & 1023u), float((h >> 20) & 1023u)) - 511.5;
  return (i < j ? 1.0 : -1.0) * inversesqrt(dot(d, d)) * d;
}
