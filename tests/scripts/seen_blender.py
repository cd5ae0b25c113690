# seen_blender.py - what `bake` writes into models, as Blender reads it: run by seen.sh as
# `blender -b --python-exit-code 1 --python seen_blender.py -- FILE.glb`. Colours of vertices must be on every mesh, some
# of them dark and some bright; an occlusionTexture must be linked to the material's output with its pixels there.
import sys
import numpy
numpy.bool = bool               # Debian 12's Blender 3.4 asks for it; its NumPy 1.24 has it no more
import bpy

file = sys.argv[-1]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=file)
meshes = [o.data for o in bpy.data.objects if o.type == 'MESH']
assert meshes, 'no mesh'
for mesh in meshes:
    if 'texture' in file:
        for material in mesh.materials:
            groups = [n for n in material.node_tree.nodes if n.bl_idname == 'ShaderNodeGroup']
            assert any(n.inputs['Occlusion'].is_linked for n in groups), material.name + ': no occlusion'
        shades = [p for image in bpy.data.images for p in list(image.pixels)[0::4]]
    else:
        assert len(mesh.color_attributes) == 1, mesh.name + ': no colours'
        shades = [d.color[0] for d in mesh.color_attributes[0].data]
    assert min(shades) < 0.2 and max(shades) > 0.8, '%s: %g to %g' % (mesh.name, min(shades), max(shades))
