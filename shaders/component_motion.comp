// The rigid motion that takes the rest of momentum out; see kernels/component_motion.decl.

void main() {
  uint c = thread_index();
  if (c >= threads) return;
  vec4 drift = vec4(0.0), centre = vec4(0.0), spin = vec4(0.0), square = vec4(0.0), mixed = vec4(0.0);
  for (uint k = component[c].x; k < component[c].y; ++k) {
    drift += moment[5 * k];
    centre += moment[5 * k + 1];
    spin += moment[5 * k + 2];
    square += moment[5 * k + 3];
    mixed += moment[5 * k + 4];
  }
  rigid[3 * c] = rigid[3 * c + 1] = rigid[3 * c + 2] = vec4(0.0);
  float m = drift.w;
  if (centre.w > 0.0 || !(m > 0.0)) return; // something else holds it: its momentum is not its own
  vec3 mean = drift.xyz / m, y = centre.xyz / m;
  rigid[3 * c] = vec4(-mean, 0.0);
  rigid[3 * c + 2] = vec4(y, 0.0);
  if (component[c].z == 0) return;
  // About the centre: L = sum m (y - c) x d, I = sum m (|y - c|^2 - (y - c)(y - c)^T).
  vec3 l = spin.xyz - m * cross(y, mean);
  vec3 s = square.xyz - m * y * y;
  vec3 t = mixed.xyz - m * vec3(y.x * y.y, y.x * y.z, y.y * y.z);
  float trace = s.x + s.y + s.z, round_off = 1e-5 * trace;
  float ixx = s.y + s.z + round_off, iyy = s.x + s.z + round_off, izz = s.x + s.y + round_off;
  float ixy = -t.x, ixz = -t.y, iyz = -t.z;
  mat3 inertia = mat3(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
  // A single particle has nothing to turn: what is left of its trace is noise.
  if (!(trace > 1e-6 * (square.x + square.y + square.z))) return;
  rigid[3 * c + 1] = vec4(-inverse(inertia / trace) * (l / trace), 0.0);
}
