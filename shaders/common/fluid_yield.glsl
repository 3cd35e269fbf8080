// Relaxation, yield and return of a neighbourhood: see plastic_return.decl. x: share of e_iso that stays; y: of e - e_iso;
// z: equivalent plastic strain that this adds; w: 1 where it yields.
vec4 what_stays(vec4 surface, float relaxed, float isotropic, float square, float strain_before, float equivalent) {
  float spread = relaxed * sqrt(square), bears = surface.z + surface.w * strain_before - surface.y * isotropic;
  if (!(surface.x * spread > bears)) return vec4(1.0, relaxed, 0.0, 0.0);
  float most = equivalent * spread; // equivalent plastic strain that leaves nothing deviatoric
  float strain = (surface.x * spread - bears) / (surface.x / equivalent + surface.w);
  if (strain < most) return vec4(1.0, relaxed * (1.0 - strain / most), strain, 1.0);
  float beyond = surface.y * isotropic - (surface.z + surface.w * (strain_before + most));
  float left = beyond > 0.0 ? 1.0 - min(beyond / (surface.y * isotropic), 1.0) : 1.0;
  return vec4(left, 0.0, most, 1.0);
}
