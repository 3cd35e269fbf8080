// Weights of bonds of fluids, for kernels with the parameters per_reach2, weight_0, weight_2 and weight_4.
float bond_weight(vec3 y) {
  float q = min(dot(y, y) * per_reach2, 1.0), a = 1.0 - q;
  return a * a * (weight_0 + q * (weight_2 + q * weight_4));
}
