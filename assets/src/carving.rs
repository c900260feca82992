//! The fine carving: curls, strands of beard and brow, horn rings, wrinkles, and the unevenness of a worked surface, as
//! heights over the smooth head.
//!
//! Guarantees: deterministic; heights stay within ±0.04, and vanish where nothing is carved.
//!
//! Non-guarantees: heights are not symmetric: curls are laid out by a hash, as a hand would not repeat itself either.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::distance_field::{bell, smoothstep};
use crate::faun::{EYE, EYE_RADIUS, along_horn, beard, behind_hairline, brow, ear, in_ear};
use crate::relax::{Target, turned_faces};
use crate::skin::Skin;
use crate::vector::{Vec3, vec3};

/// Distance between the middles of neighbouring curls.
const CURL_SPACING: f64 = 0.118;
/// Distance between the turns of a curl.
const CURL_PITCH: f64 = 0.044;

/// A snail of hair: where it sits, a frame of its tangent plane, and which way it turns.
struct Curl {
    centre: Vec3,
    axes: [Vec3; 2],
    turn: f64,
    phase: f64,
}

/// Pushes every vertex out along its normal by the height carved there, less where a face would turn
/// against the field.
pub fn carve(skin: &mut Skin, target: &Target) {
    let normals = skin.normals();
    let curls = lay_curls(skin, &normals);
    let smooth = std::mem::take(&mut skin.positions);
    let mut heights: Vec<f64> =
        smooth.par_iter().zip(&normals).map(|(&place, &normal)| height(place, normal, &curls)).collect();
    loop {
        let push = |v: usize| smooth[v] + normals[v] * heights[v];
        skin.positions = (0..smooth.len()).map(push).collect();
        let turned = turned_faces(skin, target);
        let mut lowered = vec![false; smooth.len()];
        for (face, _) in skin.faces.iter().zip(turned).filter(|(_, turned)| *turned) {
            face.iter().for_each(|&v| lowered[v as usize] = heights[v as usize] != 0.0);
        }
        if !lowered.contains(&true) {
            return;
        }
        for (height, _) in heights.iter_mut().zip(lowered).filter(|(_, lowered)| *lowered) {
            // Halving ends: what is below a hundredth of a millimetre of a two-metre head goes to zero.
            *height = if height.abs() < 1e-5 { 0.0 } else { *height * 0.5 };
        }
    }
}

fn height(p: Vec3, normal: Vec3, curls: &[Curl]) -> f64 {
    let q = vec3(p.x.abs(), p.y, p.z);
    let (along, away) = along_horn(q);
    // Horns and ears grow through hair and skin: they carry their own carving only.
    let off_horn = smoothstep(0.02, 0.07, away - 0.11 * (1.0 - along.max(0.0)));
    let off_ear = smoothstep(0.008, 0.035, ear(q, 1.0));
    let head = off_horn * off_ear;
    let mut sum = horn_rings(along, away, q) + ear_flutes(q, normal);
    let curly = curly(p) * head;
    if curly > 0.0 {
        sum += curly * curl_height(p, curls);
    }
    let bearded = bearded(p) * off_ear;
    sum += bearded * strands(p) + brow_hair(p) + head * (1.0 - curly) * (wrinkles(q) + off_eye(q) * grain(p));
    sum
}

/// 1 where curls grow: on the scalp and on the fleece round the shoulders.
fn curly(p: Vec3) -> f64 {
    let scalp = smoothstep(0.0, 0.05, behind_hairline(p)) * smoothstep(-0.44, -0.34, p.y);
    let collar = p.y + 0.22 * smoothstep(-0.1, 0.3, p.z) - 0.05 * smoothstep(0.0, -0.4, p.z);
    let fleece =
        smoothstep(-0.60, -0.65, collar) * smoothstep(-0.935, -0.90, p.y) * smoothstep(0.42, 0.32, p.z);
    scalp.max(fleece)
}

fn off_eye(q: Vec3) -> f64 {
    smoothstep(EYE_RADIUS + 0.02, EYE_RADIUS + 0.05, (q - EYE).length())
}

/// Chooses curl middles among the vertices where they grow: in hashed order, each kept if no earlier one is too near.
fn lay_curls(skin: &Skin, normals: &[Vec3]) -> Vec<Curl> {
    let mut order: Vec<usize> =
        (0..skin.positions.len()).filter(|&v| curly(skin.positions[v]) > 0.3).collect();
    order.sort_unstable_by_key(|&v| (hash(v as u32), v));
    let mut curls: Vec<Curl> = Vec::new();
    for v in order {
        let centre = skin.positions[v];
        if curls.iter().all(|curl| (curl.centre - centre).length() > CURL_SPACING) {
            let normal = normals[v];
            let first = vec3(0.3, 1.0, 0.2).without(normal).normalised();
            let turn = if hash(v as u32 ^ 0x5bd1) & 1 == 0 { 1.0 } else { -1.0 };
            let phase = f64::from(hash(v as u32 ^ 0x77) & 0xffff) / 65_536.0 * TAU;
            curls.push(Curl { centre, axes: [first, normal.cross(first)], turn, phase });
        }
    }
    curls
}

/// Domes that meet in valleys, each wound into a snail.
fn curl_height(p: Vec3, curls: &[Curl]) -> f64 {
    let (mut nearest, mut second, mut best) = (f64::INFINITY, f64::INFINITY, None);
    for curl in curls {
        let distance = (p - curl.centre).length();
        if distance < nearest {
            (second, nearest, best) = (nearest, distance, Some(curl));
        } else {
            second = second.min(distance);
        }
    }
    let Some(curl) = best else { return 0.0 };
    let offset = p - curl.centre;
    let (a, b) = (offset.dot(curl.axes[0]), offset.dot(curl.axes[1]));
    let radius = a.hypot(b);
    let angle = curl.turn * b.atan2(a) + curl.phase;
    let inside = smoothstep(0.0, 0.045, second - nearest);
    let groove = (angle + TAU * radius / CURL_PITCH).cos() * smoothstep(0.004, 0.02, radius);
    0.030 * inside - 0.012 + inside * (0.010 * groove + 0.010 * bell(nearest, 0.09))
}

/// 1 where the beard grows: chin, jaw and its tip, not the lips.
fn bearded(p: Vec3) -> f64 {
    let below_lip = smoothstep(-0.365, -0.405, p.y - 0.9 * p.x * p.x);
    let at_side = smoothstep(0.235, 0.285, p.x.abs());
    smoothstep(0.045, 0.012, beard(p)) * below_lip.max(at_side) * smoothstep(0.02, -0.06, p.y)
}

/// Wavy locks that run down the beard to its tip, each of finer strands.
fn strands(p: Vec3) -> f64 {
    let middle = 0.20 + 0.25 * smoothstep(-0.40, -0.85, p.y);
    let around = p.x.atan2(p.z - middle);
    let sway = 0.55 * (p.y * 13.0 + 1.7 * p.x.signum() * (p.x * p.x + 0.01).sqrt()).sin()
        + 0.45 * noise(vec3(p.x * 6.0, p.y * 5.0, p.z * 6.0));
    let lock = (around * 11.0 + sway * 1.3).sin();
    let strand = (around * 31.0 + sway * 3.4 + 0.8 * lock).sin();
    0.016 * (1.0 - (1.0 - lock.abs()).powi(2)) * lock.signum() * 0.75 + 0.0045 * strand
}

fn brow_hair(p: Vec3) -> f64 {
    let q = vec3(p.x.abs(), p.y, p.z);
    let on = smoothstep(0.016, 0.0, brow(q))
        * smoothstep(0.045, 0.075, q.x)
        * smoothstep(0.205, 0.23, p.y + 0.12 * q.x);
    let slant = q.x * 0.85 + p.y * 0.75 * (1.0 - 2.2 * q.x) + 0.010 * noise(p * 24.0);
    on * (0.003 + 0.0042 * (slant * TAU / 0.027).sin())
}

/// Growth rings, steep towards the root, fading towards the tip, with a fine grain along.
fn horn_rings(along: f64, away: f64, q: Vec3) -> f64 {
    let on =
        smoothstep(0.035, 0.012, away - 0.13 * (1.0 - 0.86 * along.max(0.0))) * smoothstep(0.06, 0.14, along);
    let fade = smoothstep(0.96, 0.55, along);
    let bend = 0.006 * noise(q * 14.0);
    let ring = ((along + bend) * 14.0).rem_euclid(1.0);
    let tooth = smoothstep(0.0, 0.66, ring) * smoothstep(1.0, 0.72, ring);
    on * fade * (0.017 * tooth - 0.006)
}

/// Flutes in the hollow of the ear.
fn ear_flutes(q: Vec3, normal: Vec3) -> f64 {
    let (along, across, _) = in_ear(q);
    let on =
        smoothstep(0.14, 0.30, along) * smoothstep(0.95, 0.75, along) * smoothstep(0.85, 0.60, across.abs());
    on * smoothstep(0.2, 0.5, normal.z) * 0.0055 * (across * 9.5 + 2.0 * along).cos()
}

/// Lines across the forehead.
fn wrinkles(q: Vec3) -> f64 {
    let high = q.y + 0.28 * q.x * q.x - 0.012 * (q.x * 21.0).sin();
    let forehead = bell(q.y - 0.375, 0.085) * smoothstep(0.26, 0.36, q.z) * smoothstep(0.24, 0.12, q.x);
    let lines = -((high * TAU / 0.054).sin().max(0.0));
    0.0060 * forehead * lines
}

/// The unevenness that a tool leaves.
fn grain(p: Vec3) -> f64 {
    0.0016 * noise(p * 15.0) + 0.0009 * noise(p * 41.0)
}

/// A hash with good avalanche (a 32-bit finaliser: two multiplications between shifts).
fn hash(seed: u32) -> u32 {
    let mut x = seed.wrapping_add(0x9e37_79b9);
    x = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
    x = (x ^ (x >> 15)).wrapping_mul(0x735a_2d97);
    x ^ (x >> 15)
}

/// Value noise in −1 … 1 with unit cells, smooth across them.
fn noise(p: Vec3) -> f64 {
    let cell = |value: f64| (value.floor(), value - value.floor());
    let ((i, u), (j, v), (k, w)) = (cell(p.x), cell(p.y), cell(p.z));
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let corner = |a: f64, b: f64, c: f64| {
        let mixed = hash(hash(hash((i + a) as i32 as u32) ^ (j + b) as i32 as u32) ^ (k + c) as i32 as u32);
        f64::from(mixed) / f64::from(u32::MAX) * 2.0 - 1.0
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * ease(t);
    let edge = |b: f64, c: f64| mix(corner(0.0, b, c), corner(1.0, b, c), u);
    mix(mix(edge(0.0, 0.0), edge(1.0, 0.0), v), mix(edge(0.0, 1.0), edge(1.0, 1.0), v), w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_bounded_and_continuous() {
        for step in 0..500 {
            let p = vec3(f64::from(step) * 0.037 - 9.0, f64::from(step) * 0.011, -0.3);
            assert!(noise(p).abs() <= 1.0);
            assert!((noise(p) - noise(p + vec3(1e-6, 0.0, 0.0))).abs() < 1e-4);
        }
    }
}
