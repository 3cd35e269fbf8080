// Rotations as unit quaternions (x, y, z, w), and the signed polar decomposition.

mat3 rotation_matrix(vec4 q) {
  float xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  float xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  float wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  // Columns.
  return mat3(1.0 - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy),
              2.0 * (xy - wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz + wx),
              2.0 * (xz + wy), 2.0 * (yz - wx), 1.0 - 2.0 * (xx + yy));
}

vec4 quaternion_product(vec4 a, vec4 b) {
  return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

// The unit quaternion that maximises tr(R^T S), by Horn's (1987) symmetric 4 x 4 matrix and cyclic Jacobi sweeps:
// right for every S, also singular or inverted. Where the answer is not unique (S of rank one or a mirror image)
// a small bias chooses the one nearest to no rotation.
vec4 horn_rotation(mat3 s) {
  float size = sqrt(dot(s[0], s[0]) + dot(s[1], s[1]) + dot(s[2], s[2]));
  if (!(size > 0.0)) return vec4(0.0, 0.0, 0.0, 1.0);
  s /= size;
  float n[16];
  n[0] = s[0][0] + s[1][1] + s[2][2] + 1e-5;
  n[5] = s[0][0] - s[1][1] - s[2][2];
  n[10] = s[1][1] - s[0][0] - s[2][2];
  n[15] = s[2][2] - s[0][0] - s[1][1];
  n[1] = n[4] = s[1][2] - s[2][1];
  n[2] = n[8] = s[2][0] - s[0][2];
  n[3] = n[12] = s[0][1] - s[1][0];
  n[6] = n[9] = s[0][1] + s[1][0];
  n[7] = n[13] = s[0][2] + s[2][0];
  n[11] = n[14] = s[1][2] + s[2][1];
  float v[16];
  for (int i = 0; i < 16; ++i) v[i] = (i % 5 == 0) ? 1.0 : 0.0;
  for (int sweep = 0; sweep < 10; ++sweep) {
    float off = abs(n[1]) + abs(n[2]) + abs(n[3]) + abs(n[6]) + abs(n[7]) + abs(n[11]);
    if (off < 1e-9) break;
    for (int p = 0; p < 3; ++p)
      for (int q = p + 1; q < 4; ++q) {
        float apq = n[4 * p + q];
        if (abs(apq) < 1e-20) continue;
        float theta = 0.5 * (n[5 * q] - n[5 * p]) / apq;
        float t = (theta >= 0.0 ? 1.0 : -1.0) / (abs(theta) + sqrt(theta * theta + 1.0));
        if (abs(theta) > 1e10) t = 0.5 / theta;
        float c = 1.0 / sqrt(t * t + 1.0), sn = t * c;
        for (int k = 0; k < 4; ++k) {
          float akp = n[4 * k + p], akq = n[4 * k + q];
          n[4 * k + p] = c * akp - sn * akq;
          n[4 * k + q] = sn * akp + c * akq;
        }
        for (int k = 0; k < 4; ++k) {
          float apk = n[4 * p + k], aqk = n[4 * q + k];
          n[4 * p + k] = c * apk - sn * aqk;
          n[4 * q + k] = sn * apk + c * aqk;
          float vkp = v[4 * k + p], vkq = v[4 * k + q];
          v[4 * k + p] = c * vkp - sn * vkq;
          v[4 * k + q] = sn * vkp + c * vkq;
        }
      }
  }
  int best = 0;
  for (int i = 1; i < 4; ++i)
    if (n[5 * i] > n[5 * best]) best = i;
  vec4 q = vec4(v[4 + best], v[8 + best], v[12 + best], v[best]);
  if (q.w < 0.0) q = -q;
  return normalize(q);
}

// Signed polar decomposition: the rotation (det = +1) that maximises tr(R^T S), near the start `q`.
// Newton's method on the rotations: with M = R^T S, the step w solves (tr M - sym M) w = axl(M - M^T); the matrix
// is positive definite exactly at the maximum, where the sum of the two smallest signed singular values is positive.
vec4 polar_rotation(mat3 s, vec4 q) {
  float size = abs(s[0][0]) + abs(s[1][1]) + abs(s[2][2]) + abs(s[0][1]) + abs(s[1][0]) + abs(s[0][2]) +
               abs(s[2][0]) + abs(s[1][2]) + abs(s[2][1]);
  if (!(size > 0.0)) return q;
  for (int iteration = 0; iteration < 6; ++iteration) {
    mat3 m = transpose(rotation_matrix(q)) * s; // m[column][row]
    vec3 a = vec3(m[1][2] - m[2][1], m[2][0] - m[0][2], m[0][1] - m[1][0]);
    float hxx = m[1][1] + m[2][2], hyy = m[0][0] + m[2][2], hzz = m[0][0] + m[1][1];
    float hxy = -0.5 * (m[1][0] + m[0][1]), hxz = -0.5 * (m[2][0] + m[0][2]), hyz = -0.5 * (m[2][1] + m[1][2]);
    float cxx = hyy * hzz - hyz * hyz, cxy = hxz * hyz - hxy * hzz, cxz = hxy * hyz - hxz * hyy;
    float det = hxx * cxx + hxy * cxy + hxz * cxz;
    if (!(hxx > 0.0 && hxx * hyy - hxy * hxy > 0.0 && det > 1e-5 * size * size * size)) break;
    float cyy = hxx * hzz - hxz * hxz, cyz = hxy * hxz - hxx * hyz, czz = hxx * hyy - hxy * hxy;
    vec3 w = vec3(cxx * a.x + cxy * a.y + cxz * a.z, cxy * a.x + cyy * a.y + cyz * a.z,
                  cxz * a.x + cyz * a.y + czz * a.z) / det;
    float angle2 = dot(w, w);
    if (angle2 > 1.0) break;
    q = normalize(quaternion_product(q, vec4(0.5 * w, 1.0)));
    if (angle2 < 1e-7) return q; // quadratic: the step that follows would be below one rounding
  }
  return normalize(quaternion_product(q, horn_rotation(transpose(rotation_matrix(q)) * s)));
}

// The rotation about z that maximises tr(R^T S) for S of the plane z = 0; `q` where all are alike: a point, or a mirror
// image that was not stretched.
vec4 plane_rotation(mat3 s, vec4 q) {
  float along = s[0][0] + s[1][1], across = s[0][1] - s[1][0];
  float size = abs(s[0][0]) + abs(s[1][1]) + abs(s[0][1]) + abs(s[1][0]), len = sqrt(along * along + across * across);
  if (!(len > 1e-6 * size)) return q;
  float c = along / len, n = across / len; // cosine and sine; of half the angle from the one that keeps digits
  return normalize(c >= 0.0 ? vec4(0.0, 0.0, n, 1.0 + c) : vec4(0.0, 0.0, 1.0 - c, n));
}

// Eigenvalues and vectors (columns of v) of a symmetric matrix by cyclic Jacobi.
void symmetric_eigen(mat3 a, out vec3 values, out mat3 v) {
  v = mat3(1.0);
  for (int sweep = 0; sweep < 8; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        float apq = a[q][p];
        if (abs(apq) < 1e-20) continue;
        float theta = 0.5 * (a[q][q] - a[p][p]) / apq;
        float t = (theta >= 0.0 ? 1.0 : -1.0) / (abs(theta) + sqrt(theta * theta + 1.0));
        if (abs(theta) > 1e10) t = 0.5 / theta;
        float c = 1.0 / sqrt(t * t + 1.0), sn = t * c;
        for (int k = 0; k < 3; ++k) {
          float akp = a[p][k], akq = a[q][k];
          a[p][k] = c * akp - sn * akq;
          a[q][k] = sn * akp + c * akq;
        }
        for (int k = 0; k < 3; ++k) {
          float apk = a[k][p], aqk = a[k][q];
          a[k][p] = c * apk - sn * aqk;
          a[k][q] = sn * apk + c * aqk;
        }
        vec3 vp = v[p], vq = v[q];
        v[p] = c * vp - sn * vq;
        v[q] = sn * vp + c * vq;
      }
  values = vec3(a[0][0], a[1][1], a[2][2]);
}

// F with its signed singular values raised to at least `least` (Irving et al. 2004): continuous and objective, and
// of full rank for flat, line-like and point-like shapes.
mat3 clamp_singular_values(mat3 f, float least) {
  float norm2 = dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]);
  // The smallest singular value is at least det / |F|^2: nothing to do for all but the most deformed.
  if (determinant(f) > least * norm2) return f;
  mat3 r = rotation_matrix(horn_rotation(f));
  mat3 p = transpose(r) * f;
  p = 0.5 * (p + transpose(p));
  vec3 values;
  mat3 v;
  symmetric_eigen(p, values, v);
  if (min(values.x, min(values.y, values.z)) >= least) return f;
  values = max(values, vec3(least));
  return r * (mat3(v[0] * values.x, v[1] * values.y, v[2] * values.z) * transpose(v));
}
