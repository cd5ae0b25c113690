// Draws which near point has this place in their order.
// with: ism_near_sort.vert
flat in uint ism_from;
layout(location = 0) out uint result;

void main() { result = ism_from; }
