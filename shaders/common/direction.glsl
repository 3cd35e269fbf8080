// The direction of a bond; where two particles coincide, that of the reference bond, which is antisymmetric.
vec3 bond_direction(vec3 y, vec3 xi) {
  float length2 = dot(y, y), rest2 = dot(xi, xi);
  if (length2 > 1e-14 * rest2) return y * inversesqrt(length2);
  return rest2 > 0.0 ? xi * inversesqrt(rest2) : vec3(0.0);
}
