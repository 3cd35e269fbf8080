// Smoothing functions of q = r / support, without their factors (engine/model/smoothing.h has those). Slopes are over q, so
// that the gradient is slope * y. Spiky's slope has no limit at q = 0: it is held from SPIKY_LEAST on.
const float SPIKY_LEAST = 0.05;

// Cubic spline: 6 q^3 - 6 q^2 + 1, then 2 (1 - q)^3.
float spline_value(float q) {
  float a = max(1.0 - q, 0.0), b = max(1.0 - 2.0 * q, 0.0);
  return 2.0 * a * a * a - b * b * b;
}
float spline_slope(float q) {
  float a = max(1.0 - q, 0.0);
  return q < 0.5 ? 18.0 * q - 12.0 : -6.0 * a * a / q;
}
// (1 - q)^3
float spiky_slope(float q) {
  float a = max(1.0 - q, 0.0);
  return -3.0 * a * a / max(q, SPIKY_LEAST);
}
float spiky_curvature(float q) { return 6.0 * max(1.0 - q, 0.0); }
// Laplacian of the function for viscosity: a straight line.
float viscous_laplacian(float q) { return max(1.0 - q, 0.0); }
