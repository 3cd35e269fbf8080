// A bond of law M2 at rest: weights c and lengths p over the first, of i's end and of j's: (c_ij, c_ji, p_ij, p_ji). With
// plasticity each end has its own length; its modulus stays, so that c = modulus V omega / x^2 follows.
vec4 bond_at_rest(uint entry) {
#if plastic
  vec2 p = vec2(rest[entry], rest[entry + 16]);
  return vec4(weight[entry] / (p.x * p.x), weight[entry + 16] / (p.y * p.y), p);
#else
  return vec4(weight[entry], weight[entry + 16], 1.0, 1.0);
#endif
}
