// Basis functions (Xu et al. 2018, Eqs. 15 to 17) of a stretch s = 1 + e, in e, so that nothing cancels near
// rest: with p_n(s) = 1 + s + .. + s^(n-1) and r = 1 / s,
//   A_n' = e (p_n(s) + r p_n(r)) / n    A_n'' = s^(n-1) + r^(n+1)    B_n' = 2 e p_n(s) / n    B_n'' = 2 s^(n-1)
#include "common/stretch.glsl"

// ln(1 + e) = 2 artanh(e / (2 + e)); far from rest of the fourth root.
float log_stretch(float e) {
  bool far = e > 0.6 || e < -0.4;
  float t = far ? sqrt(sqrt(1.0 + e)) : 1.0 + e;
  float z = far ? (t - 1.0) / (t + 1.0) : e / (2.0 + e), z2 = z * z;
  float series = 1.0 / 17.0;
  for (int k = 15; k > 0; k -= 2) series = series * z2 + 1.0 / float(k);
  return (far ? 8.0 : 2.0) * z * series;
}

// (e - ln(1 + e)) / e^2, 1/2 at rest.
float log_remainder(float e) {
  if (e > 0.6 || e < -0.4) return (e - log_stretch(e)) / (e * e);
  float ratio = 1.0 / (2.0 + e), z2 = e * e * ratio * ratio;
  float series = 1.0 / 19.0;
  for (int k = 17; k > 1; k -= 2) series = series * z2 + 1.0 / float(k);
  return ratio - 2.0 * e * series * ratio * ratio * ratio;
}

// f' and f'' of the sum whose rows begin there.
vec2 basis_slopes(uint row, float e) {
  float inside = clamp(e, STRETCH_LEAST - 1.0, STRETCH_MOST - 1.0), s = 1.0 + inside, r = 1.0 / s;
  vec2 sum = vec2(0.0);
  for (uint k = row; k < row + STRETCH_POWERS; ++k) {
    vec4 term = energies[k];
    int n = int(term.x);
    if (n == 0) break;
    float p = 1.0, back = 1.0, power = 1.0, root = r; // p_n(s), p_n(r), s^(n-1), r^n
    for (int m = 1; m < n; ++m) {
      p = p * s + 1.0;
      back = back * r + 1.0;
      power *= s;
      root *= r;
    }
    sum += vec2(inside / term.x * (term.y * (p + r * back) + 2.0 * term.z * p),
                term.y * (power + r * root) + 2.0 * term.z * power);
    if (term.w != 0.0) {
      float l = log_stretch(inside);
      sum += 2.0 * term.w * r * vec2(l, r * (1.0 - l));
    }
  }
  sum.x += (e - inside) * sum.y;
  return sum;
}

// f: B_n = 2 e^2 q_n(s) / (n (n + 1)) and A_n = e^2 (r + q_n(s) / (n + 1) + r^2 q_n-2(r) / (n - 1)) / n with
// q_n = p_1 + .. + p_n.
float basis_value(uint row, float e) {
  float inside = clamp(e, STRETCH_LEAST - 1.0, STRETCH_MOST - 1.0), s = 1.0 + inside, r = 1.0 / s, sum = 0.0;
  for (uint k = row; k < row + STRETCH_POWERS; ++k) {
    vec4 term = energies[k];
    int n = int(term.x);
    if (n == 0) break;
    float p = 0.0, back = 0.0, q = 0.0, behind = 0.0; // p_m(s), p_m(r), q_n(s), q_n-2(r)
    for (int m = 1; m <= n; ++m) {
      p = p * s + 1.0;
      q += p;
      back = back * r + 1.0;
      if (m <= n - 2) behind += back;
    }
    float high = q / (term.x + 1.0);
    float a = n == 1 ? 0.5 + log_remainder(inside) : (r + high + r * r * behind / (term.x - 1.0)) / term.x;
    sum += term.y * a + 2.0 * term.z * high / term.x;
    if (term.w != 0.0) {
      float ratio = abs(inside) > 1e-6 ? log_stretch(inside) / inside : 1.0;
      sum += term.w * ratio * ratio;
    }
  }
  sum *= inside * inside;
  float beyond = e - inside;
  if (beyond != 0.0) {
    vec2 slope = basis_slopes(row, inside);
    sum += beyond * (slope.x + 0.5 * beyond * slope.y);
  }
  return sum;
}
