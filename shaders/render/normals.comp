// Smooth normals by a gather: a corner sums the normals of its triangles, weighted by area.
layout(local_size_x = 128) in;
layout(std430, binding = 0) readonly buffer vertex_block { vec4 vertices[]; };   // w: field
layout(std430, binding = 1) readonly buffer corner_block { uvec4 corners[]; };   // vertex, first and last triangle
layout(std430, binding = 2) readonly buffer fan_block { uint fans[]; };          // triangles of each corner
layout(std430, binding = 3) readonly buffer triangle_block { uint triangles[]; }; // three vertices each
layout(std430, binding = 4) writeonly buffer drawn_block { vec4 drawn[]; };      // position and normal

uniform uint count, first_vertex;

void main() {
  uint i = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  if (i >= count) return;
  uvec4 corner = corners[i];
  vec3 normal = vec3(0.0);
  for (uint k = corner.y; k < corner.z; ++k) {
    uint t = 3u * fans[k];
    vec3 a = vertices[first_vertex + triangles[t]].xyz;
    vec3 b = vertices[first_vertex + triangles[t + 1u]].xyz;
    vec3 c = vertices[first_vertex + triangles[t + 2u]].xyz;
    normal += cross(b - a, c - a);
  }
  float size = length(normal);
  drawn[2u * i] = vertices[first_vertex + corner.x];
  drawn[2u * i + 1u] = vec4(size > 0.0 ? normal / size : vec3(0.0), 0.0);
}
