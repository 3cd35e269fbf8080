// The light that comes from everywhere: a clear sky above, a bright haze at the horizon.
const vec3 sun_colour = vec3(1.0, 0.955, 0.885) * 1.16;
const vec3 zenith = vec3(0.28, 0.43, 0.64);
const vec3 haze = vec3(0.72, 0.785, 0.84);
const vec3 bounce = vec3(0.27, 0.255, 0.235); // from the ground

vec3 sky(vec3 direction) {
  float height = dot(direction, up.xyz);
  vec3 colour = mix(haze, zenith, 1.0 - exp(-2.8 * max(height, 0.0)));
  float towards = max(dot(direction, to_sun.xyz), 0.0);
  return colour + sun_colour * 0.08 * pow(towards, 8.0);
}
