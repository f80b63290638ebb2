// Where the ray through a pixel meets the floor.

uniform vec3 eye;
uniform vec3 ray_corner;         // ray of pixel p: ray_corner + p.x ray_x + p.y ray_y, of distance 1
uniform vec3 ray_x;
uniform vec3 ray_y;
uniform float ground_height;
vec3 ground_point(vec3 ray) { return eye + ray * ((ground_height - eye.y) / min(ray.y, -1e-6)); }
