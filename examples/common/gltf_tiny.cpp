/* gltf_tiny.cpp - ex_gltf_parse on tinygltf: Debian's libtinygltf-dev (a shared library), or upstream's single header
   when the Makefile defines TINYGLTF_IMPLEMENTATION with the STB macros that it asks for. No other file of the project
   is C++. */
#if defined(DAPPLE_HAVE_TINYGLTF) && DAPPLE_HAVE_TINYGLTF

#include "gltf.h"
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wcast-qual"
#endif
#include <tiny_gltf.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#include <cstdio>
#include <cstring>
#include <fstream>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>
#include <sys/stat.h>

extern "C" size_t ex_memory_limit;
extern "C" int ex_normal_maps;

namespace {

/* What a file names: other files, read within a limit, and pictures, kept as they are until it is known which are used
   and how large they get. */
struct Sources {
    double left;                                        /* of ex_memory_limit */
    std::vector<std::vector<unsigned char> > pictures;  /* by number */
};

bool is_file(const std::string &name, void *)
{
    struct stat status;
    return stat(name.c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

bool read_file(std::vector<unsigned char> *out, std::string *problem, const std::string &name, void *user)
{
    Sources *sources = static_cast<Sources *>(user);
    struct stat status;
    if (stat(name.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
        if (problem) *problem += "not a file: " + name;
        return false;
    }
    sources->left -= static_cast<double>(status.st_size);
    if (sources->left < 0) throw std::runtime_error("the files that it names are too large: --limit-memory");
    std::ifstream file(name.c_str(), std::ios::binary);
    out->resize(static_cast<size_t>(status.st_size));
    if (out->empty() || file.read(reinterpret_cast<char *>(&(*out)[0]), status.st_size)) return true;
    if (problem) *problem += "cannot read " + name;
    return false;
}

/* Later versions ask for a file's size by a callback of its own. */
template <typename T> auto set_size_callback(T &files, int) -> decltype(files.GetFileSizeInBytes, void())
{
    files.GetFileSizeInBytes = [](size_t *out, std::string *, const std::string &name, void *) {
        struct stat status;
        if (stat(name.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
        *out = static_cast<size_t>(status.st_size);
        return true;
    };
}
template <typename T> void set_size_callback(T &, long) {}

bool keep_picture(tinygltf::Image *, const int number, std::string *, std::string *, int, int,
                  const unsigned char *bytes, int size, void *user)
{
    Sources *sources = static_cast<Sources *>(user);
    const size_t at = static_cast<size_t>(number);
    if (number < 0 || size <= 0) return false;
    sources->left -= size;
    if (sources->left < 0) throw std::runtime_error("its pictures are too large: --limit-memory");
    if (sources->pictures.size() <= at) sources->pictures.resize(at + 1);
    sources->pictures[at].assign(bytes, bytes + size);
    return true;
}


struct Arrays {
    std::vector<gltf_accessor> accessors;
    std::vector<gltf_primitive> primitives;
    std::vector<gltf_material> materials;
    std::vector<gltf_image> images;
    std::vector<gltf_light> lights;
    std::vector<gltf_node> nodes;
    std::vector<gltf_weights> weights;
    std::vector<gltf_target> targets;
    std::vector<gltf_skin> skins;
    std::vector<gltf_channel> channels;
    std::vector<gltf_sampler> samplers;
    std::vector<gltf_animation> animations;
    std::vector<double> yfovs;
    std::vector<int> roots;
    std::string unsupported;
};

template <typename T> bool valid(int index, const std::vector<T> &list)
{
    return index >= 0 && static_cast<size_t>(index) < list.size();
}

int attribute(const std::map<std::string, int> &attributes, const char *name)
{
    std::map<std::string, int>::const_iterator it = attributes.find(name);
    return it == attributes.end() ? -1 : it->second;
}

gltf_weights convert_weights(const std::vector<double> &from)
{
    gltf_weights to = {from.data(), from.size()};
    return to;
}

/* Member of an extension's object. */
double number_of(const tinygltf::Value &object, const char *name, double otherwise)
{
    return object.Has(name) && object.Get(name).IsNumber() ? object.Get(name).GetNumberAsDouble() : otherwise;
}

/* Image of a texture, -1 = none. */
int image_of(const tinygltf::Model &model, int texture)
{
    return valid(texture, model.textures) ? model.textures[static_cast<size_t>(texture)].source : -1;
}

/* Bytes of a buffer view from an offset on; NULL where there are none. */
const uint8_t *view_bytes(const tinygltf::Model &model, int number, double offset, size_t *count)
{
    *count = 0;
    if (!valid(number, model.bufferViews)) return nullptr;
    const tinygltf::BufferView &view = model.bufferViews[static_cast<size_t>(number)];
    if (!valid(view.buffer, model.buffers)) return nullptr;
    const std::vector<unsigned char> &data = model.buffers[static_cast<size_t>(view.buffer)].data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset) return nullptr;
    if (!(offset >= 0) || offset >= static_cast<double>(view.byteLength)) return nullptr;
    *count = view.byteLength - static_cast<size_t>(offset);
    return data.data() + view.byteOffset + static_cast<size_t>(offset);
}

gltf_accessor convert_accessor(const tinygltf::Model &model, const tinygltf::Accessor &from)
{
    gltf_accessor to = gltf_accessor();
    to.count = from.count;
    to.component_type = from.componentType;
    to.components = from.type == TINYGLTF_TYPE_SCALAR ? 1 : from.type >= 2 && from.type <= 4 ? from.type
                  : from.type == TINYGLTF_TYPE_MAT4 ? 16 : 0;
    to.normalized = from.normalized;
    to.data = view_bytes(model, from.bufferView, static_cast<double>(from.byteOffset), &to.bytes);
    if (to.data) to.stride = model.bufferViews[static_cast<size_t>(from.bufferView)].byteStride;
    if (!from.sparse.isSparse) return to;
    gltf_sparse &sparse = to.sparse;
    sparse.count = from.sparse.count > 0 ? static_cast<size_t>(from.sparse.count) : to.count + 1;    /* impossible */
    sparse.index_type = from.sparse.indices.componentType;
    sparse.indices = view_bytes(model, from.sparse.indices.bufferView,
                                static_cast<double>(from.sparse.indices.byteOffset), &sparse.index_bytes);
    sparse.values = view_bytes(model, from.sparse.values.bufferView,
                               static_cast<double>(from.sparse.values.byteOffset), &sparse.value_bytes);
    return to;
}

void convert_materials(const tinygltf::Model &model, Arrays &out)
{
    for (size_t i = 0; i < model.materials.size(); i++) {
        const tinygltf::Material &from = model.materials[i];
        const tinygltf::PbrMetallicRoughness &pbr = from.pbrMetallicRoughness;
        gltf_material to = gltf_material();
        for (size_t k = 0; k < 4; k++) to.base_color[k] = k < pbr.baseColorFactor.size() ? pbr.baseColorFactor[k] : 1;
        for (size_t k = 0; k < 3; k++) to.emissive[k] = k < from.emissiveFactor.size() ? from.emissiveFactor[k] : 0;
        to.emissive_strength = 1;
        tinygltf::ExtensionMap::const_iterator it = from.extensions.find("KHR_materials_emissive_strength");
        if (it != from.extensions.end()) to.emissive_strength = number_of(it->second, "emissiveStrength", 1);
        to.metallic = pbr.metallicFactor;
        to.roughness = pbr.roughnessFactor;
        to.alpha_cutoff = from.alphaCutoff;
        to.alpha_mode = from.alphaMode == "MASK" ? 1 : from.alphaMode == "BLEND" ? 2 : 0;
        to.double_sided = from.doubleSided;
        to.base_image = image_of(model, pbr.baseColorTexture.index);
        to.emissive_image = image_of(model, from.emissiveTexture.index);
        to.transmission_image = -1;
        it = from.extensions.find("KHR_materials_transmission");
        if (it != from.extensions.end()) {
            to.transmission = number_of(it->second, "transmissionFactor", 0);
            if (it->second.Has("transmissionTexture")) {
                double index = number_of(it->second.Get("transmissionTexture"), "index", -1);
                if (index >= 0 && index < 1e9) to.transmission_image = image_of(model, static_cast<int>(index));
            }
        }
        to.uv_set = pbr.baseColorTexture.texCoord;
        to.normal_image = ex_normal_maps ? image_of(model, from.normalTexture.index) : -1;
        to.normal_uv_set = from.normalTexture.texCoord;
        to.rough_image = ex_normal_maps ? image_of(model, pbr.metallicRoughnessTexture.index) : -1;
        to.rough_uv_set = pbr.metallicRoughnessTexture.texCoord;
        out.materials.push_back(to);
    }
}

void convert_meshes(const tinygltf::Model &model, Arrays &out)
{
    for (size_t i = 0; i < model.meshes.size(); i++) {
        out.weights.push_back(convert_weights(model.meshes[i].weights));
        for (size_t k = 0; k < model.meshes[i].primitives.size(); k++) {
            const tinygltf::Primitive &from = model.meshes[i].primitives[k];
            gltf_primitive to = gltf_primitive();
            to.mesh = static_cast<int>(i);
            to.mode = from.mode;
            to.positions = attribute(from.attributes, "POSITION");
            to.normals = attribute(from.attributes, "NORMAL");
            to.uvs[0] = attribute(from.attributes, "TEXCOORD_0");
            to.uvs[1] = attribute(from.attributes, "TEXCOORD_1");
            to.colors = attribute(from.attributes, "COLOR_0");
            to.joints[0] = attribute(from.attributes, "JOINTS_0");
            to.joints[1] = attribute(from.attributes, "JOINTS_1");
            to.weights[0] = attribute(from.attributes, "WEIGHTS_0");
            to.weights[1] = attribute(from.attributes, "WEIGHTS_1");
            to.indices = from.indices;
            to.material = from.material;
            to.first_target = out.targets.size();
            to.target_count = from.targets.size();
            for (size_t t = 0; t < from.targets.size(); t++) {
                gltf_target target = {attribute(from.targets[t], "POSITION"), attribute(from.targets[t], "NORMAL")};
                out.targets.push_back(target);
            }
            out.primitives.push_back(to);
        }
    }
}

gltf_path path_of(const std::string &name)
{
    return name == "translation" ? GLTF_TRANSLATION : name == "rotation" ? GLTF_ROTATION : name == "scale" ? GLTF_SCALE
         : name == "weights" ? GLTF_WEIGHTS : GLTF_NO_PATH;
}

gltf_interpolation interpolation_of(const std::string &name)
{
    return name == "LINEAR" ? GLTF_LINEAR : name == "STEP" ? GLTF_STEP : name == "CUBICSPLINE" ? GLTF_CUBICSPLINE
         : GLTF_NO_INTERPOLATION;
}

void convert_animations(const tinygltf::Model &model, Arrays &out)
{
    for (size_t i = 0; i < model.skins.size(); i++) {
        const tinygltf::Skin &from = model.skins[i];
        gltf_skin to = {from.joints.data(), from.joints.size(), from.inverseBindMatrices};
        out.skins.push_back(to);
    }
    for (size_t i = 0; i < model.animations.size(); i++) {
        const tinygltf::Animation &from = model.animations[i];
        gltf_animation to = {out.channels.size(), from.channels.size(), out.samplers.size(), from.samplers.size()};
        for (size_t k = 0; k < from.channels.size(); k++) {
            const tinygltf::AnimationChannel &c = from.channels[k];
            gltf_channel channel = {c.sampler, c.target_node, path_of(c.target_path)};
            out.channels.push_back(channel);
        }
        for (size_t k = 0; k < from.samplers.size(); k++) {
            const tinygltf::AnimationSampler &s = from.samplers[k];
            gltf_sampler sampler = {s.input, s.output, interpolation_of(s.interpolation)};
            out.samplers.push_back(sampler);
        }
        out.animations.push_back(to);
    }
}

void convert_lights(const tinygltf::Model &model, Arrays &out)
{
    for (size_t i = 0; i < model.lights.size(); i++) {
        const tinygltf::Light &from = model.lights[i];
        gltf_light to = gltf_light();
        to.kind = from.type == "directional" ? 0 : from.type == "point" ? 1 : from.type == "spot" ? 2 : -1;
        for (size_t k = 0; k < 3; k++) to.color[k] = k < from.color.size() ? from.color[k] : 1;
        to.intensity = from.intensity;
        to.outer_angle = from.spot.outerConeAngle;
        out.lights.push_back(to);
    }
}

void convert_nodes(const tinygltf::Model &model, Arrays &out)
{
    for (size_t i = 0; i < model.nodes.size(); i++) {
        const tinygltf::Node &from = model.nodes[i];
        gltf_node to = gltf_node();
        to.name = from.name.c_str();
        to.children = from.children.data();
        to.child_count = from.children.size();
        to.mesh = from.mesh;
        to.camera = from.camera;
        to.light = -1;
        to.skin = from.skin;
        to.weights = convert_weights(from.weights);
        tinygltf::ExtensionMap::const_iterator it = from.extensions.find("KHR_lights_punctual");
        if (it != from.extensions.end() && it->second.Has("light"))
            to.light = it->second.Get("light").GetNumberAsInt();
        to.has_matrix = from.matrix.size() == 16;
        for (size_t k = 0; to.has_matrix && k < 16; k++) to.matrix[k] = from.matrix[k];
        for (size_t k = 0; k < 3; k++) {
            to.translation[k] = from.translation.size() == 3 ? from.translation[k] : 0;
            to.scale[k] = from.scale.size() == 3 ? from.scale[k] : 1;
        }
        for (size_t k = 0; k < 4; k++) to.rotation[k] = from.rotation.size() == 4 ? from.rotation[k] : k == 3;
        out.nodes.push_back(to);
    }
}

/* Roots of the default scene, of the first one, or all nodes without a parent where the file names no scene. */
void find_roots(const tinygltf::Model &model, Arrays &out)
{
    if (!model.scenes.empty()) {
        size_t scene = valid(model.defaultScene, model.scenes) ? static_cast<size_t>(model.defaultScene) : 0;
        out.roots = model.scenes[scene].nodes;
        return;
    }
    std::vector<char> has_parent(model.nodes.size(), 0);
    for (size_t i = 0; i < model.nodes.size(); i++)
        for (size_t k = 0; k < model.nodes[i].children.size(); k++)
            if (valid(model.nodes[i].children[k], model.nodes))
                has_parent[static_cast<size_t>(model.nodes[i].children[k])] = 1;
    for (size_t i = 0; i < model.nodes.size(); i++)
        if (!has_parent[i]) out.roots.push_back(static_cast<int>(i));
}

void find_unsupported(const tinygltf::Model &model, Arrays &out)
{
    static const char *const known[] = {"KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_ior",
                                        "KHR_materials_specular", "KHR_materials_clearcoat", "KHR_materials_sheen",
                                        "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_unlit",
                                        "KHR_mesh_quantization"};
    for (size_t i = 0; i < model.extensionsRequired.size(); i++) {
        bool found = false;
        for (size_t k = 0; k < sizeof known / sizeof *known; k++) found |= model.extensionsRequired[i] == known[k];
        if (!found) out.unsupported = model.extensionsRequired[i];
    }
}

/* Decodes the pictures that materials use, once all of them are known to fit. Two copies of the pixels are kept. */
void decode_pictures(tinygltf::Model &model, Sources &sources, const Arrays &a)
{
    std::vector<char> used(model.images.size(), 0);
    for (size_t i = 0; i < a.materials.size(); i++) {
        const gltf_material &m = a.materials[i];
        const int names[5] = {m.base_image, m.emissive_image, m.transmission_image, m.normal_image, m.rough_image};
        for (int k = 0; k < 5; k++)
            if (valid(names[k], used)) used[static_cast<size_t>(names[k])] = 1;
    }
    sources.pictures.resize(model.images.size());
    for (size_t i = 0; i < used.size(); i++) {
        if (!used[i]) continue;
        const double bytes = sources.pictures[i].empty() ? 0 : ex_picture_bytes(&sources.pictures[i][0],
                                                                                sources.pictures[i].size());
        if (!(bytes > 0)) throw std::runtime_error("a picture is neither PNG nor JPEG, or this was built without stb");
        sources.left -= 2 * bytes;
        if (sources.left < 0) throw std::runtime_error("its pictures take too much memory: --limit-memory");
    }
    for (size_t i = 0; i < used.size(); i++) {
        std::string problem, warning;
        if (used[i] && !tinygltf::LoadImageData(&model.images[i], static_cast<int>(i), &problem, &warning, 0, 0,
                                                &sources.pictures[i][0], static_cast<int>(sources.pictures[i].size()),
                                                nullptr))
            throw std::runtime_error(problem);
    }
}

int show(tinygltf::Model &model, Sources &sources, gltf_visitor visit, void *context, char *error)
{
    Arrays a;
    convert_materials(model, a);
    decode_pictures(model, sources, a);
    for (size_t i = 0; i < model.accessors.size(); i++)
        a.accessors.push_back(convert_accessor(model, model.accessors[i]));
    for (size_t i = 0; i < model.images.size(); i++) {
        const tinygltf::Image &from = model.images[i];
        gltf_image to = {from.image.data(), from.image.size(), from.width, from.height, from.component, from.bits};
        a.images.push_back(to);
    }
    for (size_t i = 0; i < model.cameras.size(); i++)
        a.yfovs.push_back(model.cameras[i].type == "perspective" ? model.cameras[i].perspective.yfov : 0);
    convert_meshes(model, a);
    convert_lights(model, a);
    convert_nodes(model, a);
    convert_animations(model, a);
    find_roots(model, a);
    find_unsupported(model, a);
    gltf_file file = gltf_file();
    file.accessors = a.accessors.data();   file.accessor_count = a.accessors.size();
    file.primitives = a.primitives.data(); file.primitive_count = a.primitives.size();
    file.materials = a.materials.data();   file.material_count = a.materials.size();
    file.images = a.images.data();         file.image_count = a.images.size();
    file.lights = a.lights.data();         file.light_count = a.lights.size();
    file.nodes = a.nodes.data();           file.node_count = a.nodes.size();
    file.yfovs = a.yfovs.data();           file.camera_count = a.yfovs.size();
    file.roots = a.roots.data();           file.root_count = a.roots.size();
    file.weights = a.weights.data();       file.mesh_count = model.meshes.size();
    file.targets = a.targets.data();       file.target_count = a.targets.size();
    file.skins = a.skins.data();           file.skin_count = a.skins.size();
    file.channels = a.channels.data();     file.channel_count = a.channels.size();
    file.samplers = a.samplers.data();     file.sampler_count = a.samplers.size();
    file.animations = a.animations.data(); file.animation_count = a.animations.size();
    file.unsupported = a.unsupported.empty() ? nullptr : a.unsupported.c_str();
    return visit(context, &file, error);
}

} // namespace

extern "C" int ex_gltf_parse(const char *path, gltf_visitor visit, void *context, char *error, size_t error_size)
{
    try {
        tinygltf::TinyGLTF loader;
        tinygltf::Model model;
        Sources sources = {static_cast<double>(ex_memory_limit), std::vector<std::vector<unsigned char> >()};
        tinygltf::FsCallbacks files = tinygltf::FsCallbacks();
        files.FileExists = is_file;
        files.ExpandFilePath = tinygltf::ExpandFilePath;
        files.ReadWholeFile = read_file;
        files.WriteWholeFile = tinygltf::WriteWholeFile;
        files.user_data = &sources;
        set_size_callback(files, 0);
        loader.SetFsCallbacks(files);
        loader.SetImageLoader(keep_picture, &sources);
        std::string problem, warning, name(path);
        bool binary = name.size() > 4 && name.compare(name.size() - 4, 4, ".glb") == 0;
        bool ok = binary ? loader.LoadBinaryFromFile(&model, &problem, &warning, name)
                         : loader.LoadASCIIFromFile(&model, &problem, &warning, name);
        if (ok) return show(model, sources, visit, context, error);
        Arrays a;                            /* what an unknown extension describes cannot be parsed either */
        find_unsupported(model, a);
        if (!a.unsupported.empty())
            problem = "needs the extension " + a.unsupported + ", which is not supported";
        std::snprintf(error, error_size, "%s: %s", path, problem.empty() ? "not a glTF file" : problem.c_str());
    } catch (const std::exception &e) {      /* out of memory, or the JSON parser's own */
        std::snprintf(error, error_size, "%s: %s", path, e.what());
    }
    ex_one_line(error);
    return -1;
}

#endif
