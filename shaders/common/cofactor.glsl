// Cofactors, whose columns are cross products of the others, and symmetric matrices kept as six rows of a buffer.
mat3 cofactor(mat3 f) {
  return mat3(cross(f[1], f[2]), cross(f[2], f[0]), cross(f[0], f[1]));
}
mat3 cofactor_change(mat3 f, mat3 df) {
  return mat3(cross(df[1], f[2]) + cross(f[1], df[2]), cross(df[2], f[0]) + cross(f[2], df[0]),
              cross(df[0], f[1]) + cross(f[0], df[1]));
}
float inner(mat3 a, mat3 b) {
  return dot(a[0], b[0]) + dot(a[1], b[1]) + dot(a[2], b[2]);
}
mat3 symmetric(float xx, float xy, float xz, float yy, float yz, float zz) {
  return mat3(xx, xy, xz, xy, yy, yz, xz, yz, zz);
}
