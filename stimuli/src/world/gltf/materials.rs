//! Materials, with the one set of map coordinates that all of a material's maps share.

use super::document::{self, AlphaMode, Document, TextureInfo, TextureTransform};
use super::errors::Findings;
use super::images::{Images, Meaning};
use crate::world::Material;
use glam::{Mat2, Vec2, Vec3};

/// Where alpha is blended in the file, what is less opaque than this is left out.
const BLEND_CUTOUT: f32 = 0.5;
/// The brightest light of its own that a surface may send out.
const MOST_EMISSION: f32 = 1e6;

/// A material, and what its meshes need for it.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    pub(crate) material: Material,
    /// Which `TEXCOORD_` set its maps use; nothing without maps.
    pub(crate) uv_set: Option<u32>,
    pub(crate) transform: TextureTransform,
    /// Whether its maps repeat beyond 0–1 as ours do.
    pub(crate) repeats: bool,
    /// Whether there is anything to see; alpha may leave nothing.
    pub(crate) visible: bool,
}

impl Surface {
    /// Map coordinates after the material's transform (KHR_texture_transform: scaled, turned, moved).
    pub(crate) fn transformed(&self, uv: Vec2) -> Vec2 {
        let TextureTransform { offset, rotation, scale, .. } = self.transform;
        // Their positive angle turns the picture clockwise, with v downwards.
        Vec2::from(offset) + Mat2::from_angle(-rotation) * (Vec2::from(scale) * uv)
    }
}

/// Reads one material. A primitive without a material has the default one.
pub(crate) fn surface(
    material: &document::Material,
    place: &str,
    document: &Document,
    images: &mut Images<'_>,
    findings: &mut Findings,
) -> Surface {
    let pbr = &material.pbr_metallic_roughness;
    check_ranges(material, place, findings);
    for name in material.extensions.others.keys() {
        let name = super::accessors::shown(name);
        findings.note(place, format!("{name} is left out, the plain material is shown"));
    }

    let parts = [
        ("pbrMetallicRoughness.baseColorTexture", &pbr.base_color_texture, Meaning::Colours),
        ("normalTexture", &material.normal_texture, Meaning::Numbers),
        ("pbrMetallicRoughness.metallicRoughnessTexture", &pbr.metallic_roughness_texture, Meaning::Numbers),
        ("emissiveTexture", &material.emissive_texture, Meaning::Colours),
    ];
    let [albedo_map, normal_map, roughness_map, emission_map] = parts.map(|(part, info, meaning)| {
        let info = info.as_ref()?;
        images.map(info.index, meaning, &format!("{place}.{part}"), findings)
    });
    if material.occlusion_texture.is_some() {
        findings.note(place, "ambient occlusion is left out");
    }
    let infos = || parts.iter().filter_map(|(_, info, _)| info.as_ref());
    let used = infos().next().map(coordinates);
    if infos().any(|info| Some(coordinates(info)) != used) {
        findings.note(place, "its maps have coordinates of their own; all get those of the first");
    }

    let [r, g, b, alpha] = pbr.base_color_factor;
    let mut made = Material {
        albedo: Vec3::new(r, g, b),
        roughness: pbr.roughness_factor,
        metalness: pbr.metallic_factor,
        emission: emission(material),
        albedo_map,
        emission_map,
        normal_map,
        roughness_map,
        normal_scale: material.normal_texture.as_ref().and_then(|info| info.scale).unwrap_or(1.0),
        cutout: None,
        two_sided: material.double_sided,
        ..Material::default()
    };
    if material.extensions.unlit.is_some() {
        // What is to look the same in any light shines by itself.
        made.emission = made.albedo;
        made.emission_map = albedo_map;
        made.albedo = Vec3::ZERO;
        (made.roughness, made.metalness) = (1.0, 0.0);
        (made.normal_map, made.roughness_map) = (None, None);
    }

    let threshold = match material.alpha_mode {
        AlphaMode::Opaque => None,
        AlphaMode::Mask => Some(material.alpha_cutoff.unwrap_or(0.5)),
        AlphaMode::Blend => {
            findings.note(place, "it is not blended: what is less than half opaque is left out, the rest is opaque");
            Some(BLEND_CUTOUT)
        }
    };
    // The map's alpha counts times the factor's.
    let visible = threshold.is_none_or(|threshold| alpha >= threshold);
    made.cutout = threshold
        .filter(|&threshold| albedo_map.is_some() && threshold > 0.0)
        .map(|threshold| threshold / alpha.max(1e-6));
    Surface {
        material: made,
        uv_set: used.map(|(set, _)| set),
        transform: used.map_or_else(TextureTransform::default, |(_, transform)| transform),
        repeats: infos().all(|info| repeats(info, document)),
        visible,
    }
}

fn emission(material: &document::Material) -> Vec3 {
    let strength = material.extensions.emissive_strength.as_ref().map_or(1.0, |extension| extension.emissive_strength);
    Vec3::from(material.emissive_factor) * strength
}

/// Which set of coordinates a texture uses, and how they are transformed.
fn coordinates(info: &TextureInfo) -> (u32, TextureTransform) {
    let transform = info.extensions.transform.unwrap_or_default();
    (transform.tex_coord.unwrap_or(info.tex_coord), TextureTransform { tex_coord: None, ..transform })
}

/// Whether a texture repeats on both axes (`REPEAT`, 10497, which is also the default).
fn repeats(info: &TextureInfo, document: &Document) -> bool {
    let sampler = document.textures.get(info.index).and_then(|texture| texture.sampler);
    sampler
        .and_then(|index| document.samplers.get(index))
        .is_none_or(|sampler| [sampler.wrap_s, sampler.wrap_t].into_iter().flatten().all(|wrap| wrap == 10497))
}

fn check_ranges(material: &document::Material, place: &str, findings: &mut Findings) {
    let pbr = &material.pbr_metallic_roughness;
    let shares = [
        ("pbrMetallicRoughness.baseColorFactor", pbr.base_color_factor.as_slice()),
        ("pbrMetallicRoughness.metallicFactor", &[pbr.metallic_factor]),
        ("pbrMetallicRoughness.roughnessFactor", &[pbr.roughness_factor]),
        ("emissiveFactor", &material.emissive_factor),
    ];
    for (name, values) in shares {
        if let Some(bad) = values.iter().find(|value| !(0.0..=1.0).contains(*value)) {
            findings.wrong(format!("{place}.{name}"), format!("it has {bad}; expected 0 to 1"));
        }
    }
    let emission = emission(material);
    if !(emission.is_finite() && emission.min_element() >= 0.0 && emission.max_element() <= MOST_EMISSION) {
        let at = format!("{place}.extensions.KHR_materials_emissive_strength");
        findings.wrong(at, format!("its light of {emission} is out of range; expected 0 to {MOST_EMISSION}"));
    }
    if let Some(cutoff) = material.alpha_cutoff.filter(|cutoff| !(cutoff.is_finite() && *cutoff >= 0.0)) {
        findings.wrong(format!("{place}.alphaCutoff"), format!("it is {cutoff}; expected at least 0"));
    }
    if let Some(scale) =
        material.normal_texture.as_ref().and_then(|info| info.scale).filter(|scale| !(0.0..=1e3).contains(&scale.abs()))
    {
        findings.wrong(format!("{place}.normalTexture.scale"), format!("it is {scale}; expected −1000 to 1000"));
    }
    let textures = [
        &pbr.base_color_texture,
        &material.normal_texture,
        &pbr.metallic_roughness_texture,
        &material.emissive_texture,
    ];
    for transform in textures.into_iter().flatten().filter_map(|info| info.extensions.transform) {
        let TextureTransform { offset, rotation, scale, .. } = transform;
        if !offset.iter().chain(&scale).chain(&[rotation]).all(|x| x.abs() <= 1e6) {
            findings.wrong(
                format!("{place}.….KHR_texture_transform"),
                "its numbers are out of range; expected up to a million",
            );
        }
    }
}
