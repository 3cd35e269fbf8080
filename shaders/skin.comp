// A vertex follows the particles nearest to it; see kernels/skin.decl.

void main() {
  uint v = thread_index();
  if (v >= threads) return;
  uint k[4] = uint[4](skin_particle[v].x, skin_particle[v].y, skin_particle[v].z, skin_particle[v].w);
  vec4 w = skin_weight[v], sum = vec4(0.0);
  for (int c = 0; c < 4; ++c) {
    vec3 off = skin_reference[v].xyz - reference[k[c]].xyz;
    vec3 moved = vec3(dot(gradient[3 * k[c]].xyz, off), dot(gradient[3 * k[c] + 1].xyz, off),
                      dot(gradient[3 * k[c] + 2].xyz, off));
    sum += w[c] * (particle[k[c]] + vec4(moved, 0.0));
  }
  vertex[v] = sum;
}
