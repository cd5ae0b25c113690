// csm_point - what is shaded: a point of a surface with its material.
// uses: csm_access cohsm_brdf
struct csm_point {
    vec3 position, normal;      // world; the unit shading normal
    vec3 geometric;             // unit; offsets go along it, and light from below it is cut
    vec3 tangent;               // for anisotropic lobes; zero for any
    cohsm_material material;
    uint self;                  // instance that the point lies on, or COHSM_NO_SELF
    uint plane;                 // 1 + the receiver plane that it lies on, or 0
};
