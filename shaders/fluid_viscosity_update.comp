// See kernels/fluid_viscosity_update.decl.
#include "common/fluid_viscosity.glsl"

void main() {
  uint i = thread_index();
  if (i >= threads || fluid_viscosity[VISCOSITY_STOP] > 0.0) return;
  float keep = fluid_viscosity[VISCOSITY_KEEP], along = fluid_viscosity[VISCOSITY_STEP];
  vec3 p = fluid_residual[i].xyz, image = fluid_image[i].xyz;
  if (keep != 0.0) { // at first there is no last direction
    p += keep * fluid_direction[i].xyz;
    image += keep * fluid_direction_image[i].xyz;
  }
  fluid_direction[i] = vec4(p, 0.0);
  fluid_direction_image[i] = vec4(image, 0.0);
  if (!(fluid_residual[i].w > 0.0)) return;
  fluid_residual[i].xyz -= along * image;
  fluid_velocity[i].xyz += along * p;
}
