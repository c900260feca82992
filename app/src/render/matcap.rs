//! Materials as pictures of a lit ball, made here rather than loaded: no asset file, and every number is named.
//!
//! A matcap holds the light that leaves a ball, seen from the front, for every direction its surface can face.
//! Looking it up by the normal costs one texture read however many lights it was made with. Light is added up
//! linearly here; the texture holds it sRGB-encoded.

use glam::Vec3;

use super::gpu::Gpu;

/// Pixels along a side. The lights are soft, so this is plenty.
const SIDE: u32 = 256;

/// A directional light with a soft edge.
struct Light {
    /// Towards the light; x right, y up, z towards the eye. Made unit on use.
    towards: Vec3,
    /// How far it reaches around the ball's edge, as a fraction of the radius.
    wrap: f32,
    color: Vec3,
}

/// A highlight: the mirror image of the key light, blurred.
struct Gloss {
    /// Larger is sharper.
    sharpness: f32,
    strength: f32,
}

/// What a ball is made of and how it is lit.
struct Material {
    /// Linear reflectance.
    albedo: Vec3,
    gloss: [Gloss; 2],
    /// Strength of the cool light along the silhouette.
    rim: f32,
    /// Light left where the ball turns away, as a fraction: gives edges weight without outlining them.
    turning: f32,
}

/// Warm and matt, with just enough sheen to show which way a slope runs.
const CLAY: Material = Material {
    albedo: Vec3::new(0.43, 0.262, 0.182),
    gloss: [Gloss { sharpness: 8.0, strength: 0.045 }, Gloss { sharpness: 46.0, strength: 0.085 }],
    rim: 0.52,
    turning: 0.40,
};

/// Pale, with a broad veil and a clear highlight.
const PORCELAIN: Material = Material {
    albedo: Vec3::new(0.62, 0.595, 0.555),
    gloss: [Gloss { sharpness: 26.0, strength: 0.10 }, Gloss { sharpness: 420.0, strength: 0.55 }],
    rim: 0.42,
    turning: 0.42,
};

/// Warm and soft, from the upper left and in front.
const KEY: Light =
    Light { towards: Vec3::new(-0.52, 0.66, 0.56), wrap: 0.10, color: Vec3::new(1.42, 1.31, 1.15) };
/// Cool and weak, from the lower right, so that shadows keep their form.
const FILL: Light =
    Light { towards: Vec3::new(0.80, -0.22, 0.42), wrap: 0.35, color: Vec3::new(0.085, 0.115, 0.17) };
/// From straight ahead: keeps what faces the eye readable.
const FRONT: Light =
    Light { towards: Vec3::new(0.0, 0.1, 1.0), wrap: 0.0, color: Vec3::new(0.085, 0.08, 0.075) };
/// What comes from above and below, everywhere.
const SKY: Vec3 = Vec3::new(0.12, 0.14, 0.175);
const GROUND: Vec3 = Vec3::new(0.05, 0.04, 0.036);
/// The silhouette's light, strongest to the right, where the key does not reach.
const RIM_COLOR: Vec3 = Vec3::new(0.58, 0.76, 1.0);
const RIM_TOWARDS: Vec3 = Vec3::new(0.86, 0.30, 0.0);

/// Clay and porcelain, as layers 0 and 1 of one texture. The fourth channel is the light alone, encoded and
/// halved, for tints to be lit by.
pub(super) fn texture(gpu: &Gpu) -> wgpu::Texture {
    let materials = [CLAY, PORCELAIN];
    let size = wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: materials.len() as u32 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("matcaps"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let pixels: Vec<u8> = materials.iter().flat_map(ball).collect();
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIDE * 4), rows_per_image: Some(SIDE) };
    gpu.queue.write_texture(texture.as_image_copy(), &pixels, layout, size);
    texture
}

/// The picture of one ball, row by row from the top.
fn ball(material: &Material) -> Vec<u8> {
    let mut pixels = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    let coordinate = |index: u32| (index as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
    for row in 0..SIDE {
        for column in 0..SIDE {
            let (color, light) = material.shade(normal_at(coordinate(column), -coordinate(row)));
            pixels.extend(color.to_array().map(|channel| byte(encoded(channel))));
            pixels.push(byte(encoded(light) * 0.5));
        }
    }
    pixels
}

/// The direction the ball faces at a place of the disc; beyond its edge, that of the nearest edge.
fn normal_at(x: f32, y: f32) -> Vec3 {
    let reach = (x * x + y * y).sqrt();
    if reach >= 1.0 {
        Vec3::new(x / reach, y / reach, 0.0)
    } else {
        Vec3::new(x, y, (1.0 - reach * reach).sqrt())
    }
}

impl Material {
    /// The colour that leaves towards the eye, and the neutral light that fell there.
    fn shade(&self, normal: Vec3) -> (Vec3, f32) {
        let sky = GROUND.lerp(SKY, normal.y * 0.5 + 0.5);
        let turning = self.turning + (1.0 - self.turning) * smooth(normal.z / 0.62);
        let diffuse = (KEY.on(normal) + FILL.on(normal) + FRONT.on(normal) + sky) * turning;

        let half = (KEY.towards.normalize() + Vec3::Z).normalize();
        let shine: f32 =
            self.gloss.iter().map(|g| g.strength * normal.dot(half).max(0.0).powf(g.sharpness)).sum();

        let edge = (1.0 - normal.z).powf(3.4);
        let side = 0.22 + 0.78 * smooth(normal.dot(RIM_TOWARDS.normalize()) * 0.7 + 0.3);
        let rim = RIM_COLOR * (self.rim * edge * side);

        let added = KEY.color * shine + rim;
        let luminance = |color: Vec3| color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        (shoulder(self.albedo * diffuse + added), luminance(diffuse + added))
    }
}

impl Light {
    fn on(&self, normal: Vec3) -> Vec3 {
        let facing = normal.dot(self.towards.normalize());
        self.color * ((facing + self.wrap) / (1.0 + self.wrap)).max(0.0)
    }
}

/// Eases from 0 to 1 as `x` does.
fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Leaves the darks alone and rolls the brights off, so that highlights keep their shape below white.
fn shoulder(color: Vec3) -> Vec3 {
    const KNEE: f32 = 0.55;
    let roll =
        |c: f32| if c <= KNEE { c } else { KNEE + (1.0 - KNEE) * (1.0 - (-(c - KNEE) / (1.0 - KNEE)).exp()) };
    Vec3::new(roll(color.x), roll(color.y), roll(color.z))
}

/// Linear light as an sRGB-encoded channel.
fn encoded(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn byte(channel: f32) -> u8 {
    (channel.clamp(0.0, 1.0) * 255.0).round() as u8
}
