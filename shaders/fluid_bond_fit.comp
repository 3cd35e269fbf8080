// Eq. 20 in lengths; see kernels/fluid_bond_fit.decl.
#include "common/fluid_bond.glsl"
#include "common/fluid_bond_weight.glsl"
#include "common/near.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads) return;
  uint slice = i / 16u, first = 16u * rows * slice + i % 16u, count = near_count[slice];
  vec3 yi = fluid_start[i].xyz, period = vec3(period_x, period_y, period_z);
  bool news = false;
  float sum = 0.0, ratios = 0.0, strains = 0.0, squares = 0.0;
  for (uint r = 0u; r < count; ++r) {
    uint entry = first + 16u * r;
    float rest = near_rest[entry];
    news = news || rest < 0.0;
    if (!(rest > 0.0)) continue;
    vec3 y = shortest(fluid_start[near[entry]].xyz - yi, period);
    float w = bond_weight(y), size2 = dot(y, y), e = sqrt(size2) / rest - 1.0;
    if (!(w > 0.0) || !(size2 > SHORTEST_BOND)) continue;
    sum += w;
    ratios += w * (rest * rest / size2);
    strains += w * e;
    squares += w * e * e;
  }
  if (!news) return;
  if (!(sum > 0.0)) {
    fluid_fit[2u * i] = vec4(1.0, 1.0, 1.0, 0.0);
    fluid_fit[2u * i + 1u] = vec4(0.0, 0.0, 1.0, 1.0);
    return;
  }
  float mean = ratios / sum, isotropic = strains / sum;
  float spread = sqrt(max(squares / sum - isotropic * isotropic, 0.0));
  // Normal equations over (nx^2, ny^2, nz^2, 2 ny nz, 2 nx nz, 2 nx ny).
  float m[6][6], right[6], a[6];
  for (int p = 0; p < 6; ++p) {
    right[p] = a[p] = 0.0;
    for (int q = 0; q < 6; ++q) m[p][q] = 0.0;
  }
  for (uint r = 0u; r < count; ++r) {
    uint entry = first + 16u * r;
    float rest = near_rest[entry];
    if (!(rest > 0.0)) continue;
    vec3 y = shortest(fluid_start[near[entry]].xyz - yi, period);
    float w = bond_weight(y) / sum, size2 = dot(y, y);
    if (!(w > 0.0) || !(size2 > SHORTEST_BOND)) continue;
    vec3 n = y / sqrt(size2);
    float phi[6] = float[6](n.x * n.x, n.y * n.y, n.z * n.z, 2.0 * n.y * n.z, 2.0 * n.x * n.z, 2.0 * n.x * n.y);
    float off = rest * rest / size2 - mean;
    for (int p = 0; p < 6; ++p) {
      right[p] += w * phi[p] * off;
      for (int q = 0; q <= p; ++q) m[p][q] += w * phi[p] * phi[q];
    }
  }
  float l[6][6]; // Cholesky's factor of m with the ridge
  for (int p = 0; p < 6; ++p)
    for (int q = 0; q <= p; ++q) {
      float value = m[p][q] + (p == q ? FIT_RIDGE : 0.0);
      for (int k = 0; k < q; ++k) value -= l[p][k] * l[q][k];
      l[p][q] = p == q ? sqrt(max(value, 0.1 * FIT_RIDGE)) : value / l[q][q];
    }
  for (int pass = 0; pass < FIT_PASSES; ++pass) {
    float x[6];
    for (int p = 0; p < 6; ++p) {
      x[p] = right[p];
      for (int q = 0; q < 6; ++q) x[p] -= (q <= p ? m[p][q] : m[q][p]) * a[q];
    }
    for (int p = 0; p < 6; ++p) {
      for (int k = 0; k < p; ++k) x[p] -= l[p][k] * x[k];
      x[p] /= l[p][p];
    }
    for (int p = 5; p >= 0; --p) {
      for (int k = p + 1; k < 6; ++k) x[p] -= l[k][p] * x[k];
      x[p] /= l[p][p];
      a[p] += x[p];
    }
  }
  fluid_fit[2u * i] = vec4(mean + a[0], mean + a[1], mean + a[2], a[3]);
  fluid_fit[2u * i + 1u] =
      vec4(a[4], a[5], max(1.0 + isotropic - excess * spread, 0.05), max(1.0 + isotropic + excess * spread, 0.05));
}
