/* gpu_cost - what a driver's compiler makes of a program, without a GPU: Mesa's RADV compiles for a chip that is not
   there if RADV_FORCE_FAMILY names one, and VK_KHR_pipeline_executable_properties tells registers, spills and more.

   gpu_cost NAME MODULE.spv [FRAGMENT.spv]    a compute program, or a vertex and a fragment program

   Prints "NAME compute|fragment VGPRS SGPRS SPILLS SCRATCH LDS CODE INSTRUCTIONS THROUGHPUT WAVES SECONDS", one line;
   without arguments the chip and the driver's version. The vertex program of a pair is not counted: it draws a screen
   or the user's meshes. tools/gpu-cost calls it. */

#define _POSIX_C_SOURCE 200809L
#include <vulkan/vulkan.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST_BINDINGS = 64, MOST_OUTPUTS = 8, MOST_FACTS = 64 };

static void fail(const char *what)
{
    fprintf(stderr, "gpu_cost: %s\n", what);
    exit(1);
}

static void check(VkResult result, const char *what)
{
    if (result == VK_SUCCESS) return;
    fprintf(stderr, "gpu_cost: %s: result %d\n", what, (int)result);
    exit(1);
}

/* ---- SPIR-V: what a module binds, and what it writes ---- */

typedef struct module { uint32_t *words; size_t count; } module;

/* One word about each id: its instruction's place, its binding and its location, UINT32_MAX where there is none. */
typedef struct ids { uint32_t count, *at, *binding, *location, *block; } ids;

enum {          /* opcodes and storage classes of SPIR-V, as its specification numbers them */
    OP_TYPE_INT = 21, OP_TYPE_FLOAT = 22, OP_TYPE_VECTOR = 23, OP_TYPE_IMAGE = 25, OP_TYPE_SAMPLED_IMAGE = 27,
    OP_TYPE_ARRAY = 28, OP_TYPE_POINTER = 32, OP_CONSTANT = 43, OP_VARIABLE = 59, OP_DECORATE = 71,
    DECORATION_BUFFER_BLOCK = 3, DECORATION_LOCATION = 30, DECORATION_BINDING = 33,
    CLASS_UNIFORM_CONSTANT = 0, CLASS_UNIFORM = 2, CLASS_OUTPUT = 3, CLASS_STORAGE_BUFFER = 12
};

static module read_module(const char *path)
{
    FILE *f = fopen(path, "rb");
    module m = { NULL, 0 };
    long bytes;
    if (!f || fseek(f, 0, SEEK_END) != 0 || (bytes = ftell(f)) < 20 || fseek(f, 0, SEEK_SET) != 0) fail(path);
    m.count = (size_t)bytes / 4;
    m.words = (uint32_t *)malloc(m.count * 4);
    if (!m.words || fread(m.words, 4, m.count, f) != m.count || m.words[0] != 0x07230203u) fail(path);
    fclose(f);
    return m;
}

static ids read_ids(const module *m)
{
    ids all = { m->words[3], NULL, NULL, NULL, NULL };
    size_t i;
    uint32_t k;
    all.at = (uint32_t *)malloc(4 * sizeof(uint32_t) * all.count);
    if (!all.at) fail("out of memory");
    all.binding = all.at + all.count;
    all.location = all.binding + all.count;
    all.block = all.location + all.count;
    for (k = 0; k < 4 * all.count; k++) all.at[k] = UINT32_MAX;
    for (i = 5; i < m->count; i += m->words[i] >> 16) {
        const uint32_t *w = m->words + i, op = w[0] & 0xffffu;
        if (w[0] >> 16 == 0) fail("a module that ends early");
        if (op == OP_DECORATE && w[2] == DECORATION_BINDING) all.binding[w[1]] = w[3];
        if (op == OP_DECORATE && w[2] == DECORATION_LOCATION) all.location[w[1]] = w[3];
        if (op == OP_DECORATE && w[2] == DECORATION_BUFFER_BLOCK) all.block[w[1]] = 1;
        if (op >= OP_TYPE_INT && op <= OP_TYPE_POINTER) all.at[w[1]] = (uint32_t)i;
        if (op == OP_CONSTANT || op == OP_VARIABLE) all.at[w[2]] = (uint32_t)i;
    }
    return all;
}

static const uint32_t *instruction(const module *m, const ids *all, uint32_t id)
{
    static const uint32_t none[8] = { 0, 0, 0, 0, 0, 0, 0, 0 };
    return id < all->count && all->at[id] != UINT32_MAX ? m->words + all->at[id] : none;
}

/* The type behind a pointer and an array; *count: elements. */
static uint32_t bare_type(const module *m, const ids *all, uint32_t pointer, uint32_t *count)
{
    const uint32_t *p = instruction(m, all, pointer), *t = instruction(m, all, p[3]);
    *count = 1;
    if ((t[0] & 0xffffu) != OP_TYPE_ARRAY) return p[3];
    *count = instruction(m, all, t[3])[3];
    return t[2];
}

static VkDescriptorType descriptor_type(const module *m, const ids *all, uint32_t type, uint32_t class)
{
    const uint32_t *t = instruction(m, all, type);
    if (class == CLASS_STORAGE_BUFFER || all->block[type] == 1) return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    if (class == CLASS_UNIFORM) return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    if ((t[0] & 0xffffu) == OP_TYPE_IMAGE) return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
}

typedef struct interface {
    VkDescriptorSetLayoutBinding bindings[MOST_BINDINGS];
    uint32_t binding_count, output_count;
    VkFormat outputs[MOST_OUTPUTS];
} interface;

static void add_binding(interface *out, uint32_t binding, VkDescriptorType type, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < out->binding_count && out->bindings[i].binding != binding; i++) { }
    if (i == MOST_BINDINGS) fail("too many bindings");
    memset(&out->bindings[i], 0, sizeof out->bindings[i]);
    out->bindings[i].binding = binding;
    out->bindings[i].descriptorType = type;
    out->bindings[i].descriptorCount = count;
    out->bindings[i].stageFlags = VK_SHADER_STAGE_ALL;
    if (i == out->binding_count) out->binding_count++;
}

/* Whole numbers want targets of whole numbers: else their arithmetic would be thrown away. */
static VkFormat output_format(const module *m, const ids *all, uint32_t type)
{
    const uint32_t *t = instruction(m, all, type);
    if ((t[0] & 0xffffu) == OP_TYPE_VECTOR) t = instruction(m, all, t[2]);
    if ((t[0] & 0xffffu) != OP_TYPE_INT) return VK_FORMAT_R32G32B32A32_SFLOAT;
    return t[3] ? VK_FORMAT_R32G32B32A32_SINT : VK_FORMAT_R32G32B32A32_UINT;
}

static void add_interface(interface *out, const module *m, int fragment)
{
    const ids all = read_ids(m);
    uint32_t id;
    for (id = 0; id < all.count; id++) {
        const uint32_t *w = instruction(m, &all, id);
        uint32_t count, type;
        if ((w[0] & 0xffffu) != OP_VARIABLE) continue;
        type = bare_type(m, &all, w[1], &count);
        if (all.binding[id] != UINT32_MAX)
            add_binding(out, all.binding[id], descriptor_type(m, &all, type, w[3]), count);
        if (fragment && w[3] == CLASS_OUTPUT && all.location[id] < MOST_OUTPUTS) {
            out->outputs[all.location[id]] = output_format(m, &all, type);
            if (all.location[id] >= out->output_count) out->output_count = all.location[id] + 1;
        }
    }
    free(all.at);
}

/* ---- the device, and pipelines ---- */

typedef struct gpu { VkInstance instance; VkPhysicalDevice physical; VkDevice device; } gpu;

static void print_driver(VkPhysicalDevice physical)
{
    VkPhysicalDeviceDriverProperties driver = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES };
    VkPhysicalDeviceProperties2 all = { .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &driver };
    vkGetPhysicalDeviceProperties2(physical, &all);
    printf("%s, %s\n", all.properties.deviceName, driver.driverInfo);
}

static gpu open_gpu(void)
{
    static const char *const extensions[] = { "VK_KHR_pipeline_executable_properties", "VK_KHR_dynamic_rendering" };
    const float priority = 1;
    gpu g = { NULL, NULL, NULL };
    uint32_t count = 1;
    VkApplicationInfo app = { .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3 };
    VkInstanceCreateInfo instance = { .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &app };
    VkDeviceQueueCreateInfo queue = { .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1,
                                      .pQueuePriorities = &priority };
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR facts = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR,
        .pipelineExecutableInfo = VK_TRUE };
    VkPhysicalDeviceDynamicRenderingFeatures rendering = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES, .pNext = &facts,
        .dynamicRendering = VK_TRUE };
    VkDeviceCreateInfo device = { .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &rendering,
                                  .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue,
                                  .enabledExtensionCount = 2, .ppEnabledExtensionNames = extensions };
    check(vkCreateInstance(&instance, NULL, &g.instance), "vkCreateInstance");
    if (vkEnumeratePhysicalDevices(g.instance, &count, &g.physical) < 0 || count == 0) fail("no device");
    check(vkCreateDevice(g.physical, &device, NULL, &g.device), "vkCreateDevice");
    return g;
}

static VkPipelineLayout make_layout(const gpu *g, const interface *in)
{
    VkDescriptorSetLayoutCreateInfo set = { .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                            .bindingCount = in->binding_count, .pBindings = in->bindings };
    VkDescriptorSetLayout set_layout;
    VkPipelineLayoutCreateInfo info = { .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1,
                                        .pSetLayouts = &set_layout };
    VkPipelineLayout layout;
    check(vkCreateDescriptorSetLayout(g->device, &set, NULL, &set_layout), "vkCreateDescriptorSetLayout");
    check(vkCreatePipelineLayout(g->device, &info, NULL, &layout), "vkCreatePipelineLayout");
    return layout;
}

static VkPipelineShaderStageCreateInfo make_stage(const gpu *g, const module *m, VkShaderStageFlagBits stage)
{
    VkShaderModuleCreateInfo info = { .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = 4 * m->count,
                                      .pCode = m->words };
    VkPipelineShaderStageCreateInfo out = { .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                            .stage = stage, .pName = "main" };
    check(vkCreateShaderModule(g->device, &info, NULL, &out.module), "vkCreateShaderModule");
    return out;
}

static VkPipeline make_compute(const gpu *g, const module *m, VkPipelineLayout layout)
{
    VkComputePipelineCreateInfo info = { .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                         .flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR, .layout = layout };
    VkPipeline pipeline;
    info.stage = make_stage(g, m, VK_SHADER_STAGE_COMPUTE_BIT);
    check(vkCreateComputePipelines(g->device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline), "vkCreateComputePipelines");
    return pipeline;
}

static VkPipeline make_graphics(const gpu *g, const module *m, const interface *in, VkPipelineLayout layout)
{
    VkPipelineShaderStageCreateInfo stages[2] = { make_stage(g, &m[0], VK_SHADER_STAGE_VERTEX_BIT),
                                                  make_stage(g, &m[1], VK_SHADER_STAGE_FRAGMENT_BIT) };
    VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO };
    VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST };
    VkPipelineViewportStateCreateInfo viewport = { .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                                   .viewportCount = 1, .scissorCount = 1 };
    VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1 };
    VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT };
    VkPipelineColorBlendAttachmentState masks[MOST_OUTPUTS];
    VkPipelineColorBlendStateCreateInfo blend = { .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                  .attachmentCount = in->output_count, .pAttachments = masks };
    const VkDynamicState changing[2] = { VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR };
    VkPipelineDynamicStateCreateInfo dynamic = { .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                 .dynamicStateCount = 2, .pDynamicStates = changing };
    VkPipelineRenderingCreateInfo targets = { .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                              .colorAttachmentCount = in->output_count,
                                              .pColorAttachmentFormats = in->outputs };
    VkGraphicsPipelineCreateInfo info = { .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, .pNext = &targets,
                                          .flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR, .stageCount = 2,
                                          .pStages = stages, .pVertexInputState = &input,
                                          .pInputAssemblyState = &assembly, .pViewportState = &viewport,
                                          .pRasterizationState = &raster, .pMultisampleState = &samples,
                                          .pColorBlendState = &blend, .pDynamicState = &dynamic, .layout = layout };
    VkPipeline pipeline;
    memset(masks, 0, sizeof masks);
    for (uint32_t i = 0; i < in->output_count; i++) masks[i].colorWriteMask = 15;
    check(vkCreateGraphicsPipelines(g->device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline),
          "vkCreateGraphicsPipelines");
    return pipeline;
}

/* ---- what the driver says of it ---- */

static uint64_t fact(const VkPipelineExecutableStatisticKHR *facts, uint32_t count, const char *name)
{
    uint32_t i;
    for (i = 0; i < count; i++)
        if (strcmp(facts[i].name, name) == 0) return facts[i].value.u64;
    return 0;
}

static void print_facts(const gpu *g, VkPipeline pipeline, const char *name, VkShaderStageFlagBits stage,
                        double seconds)
{
    PFN_vkGetPipelineExecutablePropertiesKHR list = (PFN_vkGetPipelineExecutablePropertiesKHR)vkGetDeviceProcAddr(
        g->device, "vkGetPipelineExecutablePropertiesKHR");
    PFN_vkGetPipelineExecutableStatisticsKHR ask = (PFN_vkGetPipelineExecutableStatisticsKHR)vkGetDeviceProcAddr(
        g->device, "vkGetPipelineExecutableStatisticsKHR");
    VkPipelineInfoKHR of = { .sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, .pipeline = pipeline };
    VkPipelineExecutablePropertiesKHR parts[8];
    VkPipelineExecutableStatisticKHR facts[MOST_FACTS];
    uint32_t count = 8, i, k;
    memset(parts, 0, sizeof parts);
    for (i = 0; i < count; i++) parts[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR;
    check(list(g->device, &of, &count, parts), "vkGetPipelineExecutablePropertiesKHR");
    for (i = 0; i < count; i++) {
        VkPipelineExecutableInfoKHR one = { .sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR,
                                            .pipeline = pipeline, .executableIndex = i };
        uint32_t n = MOST_FACTS;
        if (!(parts[i].stages & stage)) continue;
        memset(facts, 0, sizeof facts);
        for (k = 0; k < n; k++) facts[k].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
        check(ask(g->device, &one, &n, facts), "vkGetPipelineExecutableStatisticsKHR");
        printf("%s %s %llu %llu %llu %llu %llu %llu %llu %llu %llu %.2f\n", name,
               stage == VK_SHADER_STAGE_COMPUTE_BIT ? "compute" : "fragment",
               (unsigned long long)fact(facts, n, "VGPRs"), (unsigned long long)fact(facts, n, "SGPRs"),
               (unsigned long long)(fact(facts, n, "Spilled VGPRs") + fact(facts, n, "Spilled SGPRs")),
               (unsigned long long)fact(facts, n, "Scratch size"), (unsigned long long)fact(facts, n, "LDS size"),
               (unsigned long long)fact(facts, n, "Code size"), (unsigned long long)fact(facts, n, "Instructions"),
               (unsigned long long)fact(facts, n, "Inverse Throughput"),
               (unsigned long long)fact(facts, n, "Subgroups per SIMD"), seconds);
    }
}

int main(int argc, char **argv)
{
    gpu g = open_gpu();
    module modules[2];
    interface in;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    struct timespec start, end;
    const int pair = argc == 4;
    if (argc == 1) return print_driver(g.physical), 0;
    if (argc != 3 && argc != 4) return fprintf(stderr, "usage: gpu_cost [NAME MODULE.spv [FRAGMENT.spv]]\n"), 2;
    memset(&in, 0, sizeof in);
    for (int i = 0; i <= pair; i++) {
        modules[i] = read_module(argv[2 + i]);
        add_interface(&in, &modules[i], i == 1);
    }
    for (uint32_t i = 0; i < in.output_count; i++)
        if (in.outputs[i] == VK_FORMAT_UNDEFINED) in.outputs[i] = VK_FORMAT_R32G32B32A32_SFLOAT;
    layout = make_layout(&g, &in);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &start);
    pipeline = pair ? make_graphics(&g, modules, &in, layout) : make_compute(&g, &modules[0], layout);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    print_facts(&g, pipeline, argv[1], pair ? VK_SHADER_STAGE_FRAGMENT_BIT : VK_SHADER_STAGE_COMPUTE_BIT,
                (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec));
    return 0;
}
