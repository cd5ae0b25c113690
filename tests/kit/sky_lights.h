/* sky_lights.h - lights of envlights.h as envshadow.h takes them. Include both headers before. */
#ifndef DAPPLE_SKY_LIGHTS_H
#define DAPPLE_SKY_LIGHTS_H

static inline envsh_lights lights_of_sky(const envlt_light *list, uint32_t count)
{
    envsh_lights lights;
    lights.count = count;
    lights.directions = list ? list->direction : NULL;
    lights.irradiances = list ? list->irradiance : NULL;
    lights.axes_u = list ? list->axis_u : NULL;
    lights.axes_v = list ? list->axis_v : NULL;
    lights.stride = sizeof *list;
    return lights;
}

/* A pointer to them, for the call that it is written into. */
#define AS_LIGHTS(list, count) ((const envsh_lights[]){ lights_of_sky((list), (count)) })

#endif
