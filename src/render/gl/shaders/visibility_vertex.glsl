// Number of the triangle (of its last vertex, counted from 1), of its surface modulo 8, and which way it
// faces.

layout(location = 0) in vec3 position;
uniform mat4 world_to_clip;
uniform float clip_height;
uniform int surface;
flat out int number;
void main() {
    gl_Position = world_to_clip * vec4(position, 1.0);
    gl_ClipDistance[0] = position.y - clip_height;
    number = gl_VertexID + 1 + (surface << 28);
}
