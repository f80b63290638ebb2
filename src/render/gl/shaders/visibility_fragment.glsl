flat in int number;
out uint fragment;
void main() { fragment = uint(number) | (gl_FrontFacing ? 0x80000000u : 0u); }
