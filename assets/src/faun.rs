//! The faun's head as a distance field: skull, face, beard, ears and young horns, smoothly joined, and the carving on
//! top of them.
//!
//! The model is symmetric: everything is described for x ≥ 0 and mirrored. Seen from [`CENTRE`] nearly nothing hides
//! anything, so rays from there meet the surface once almost everywhere.

use crate::distance_field::{
    bell, ellipsoid, smooth_intersection, smooth_subtraction, smooth_union, smoothstep, sphere,
    tapered_capsule,
};
use crate::vector::{Vec3, vec3};

/// The middle of the head, from which its directions are taken.
pub const CENTRE: Vec3 = vec3(0.0, 0.02, 0.02);

/// The horn's ends and its radius at them.
const HORN: [Vec3; 2] = [vec3(0.19, 0.46, 0.20), vec3(0.36, 0.93, 0.32)];
const HORN_RADII: (f64, f64) = (0.125, 0.03);
/// The ear's centre line.
const EAR: [Vec3; 2] = [vec3(0.36, 0.05, -0.06), vec3(0.84, 0.24, -0.17)];
const EAR_WIDTH: f64 = 0.155;
const EYE: Vec3 = vec3(0.172, 0.085, 0.335);
const EYE_RADIUS: f64 = 0.092;

/// The smooth form, without carving.
pub fn form(p: Vec3) -> f64 {
    let p = vec3(p.x.abs(), p.y, p.z);
    let head = face(p, skull(p));
    let body = smooth_union(head, nape(p), 0.09);
    let body = smooth_union(body, beard(p), 0.07);
    let body = smooth_union(body, ear(p), 0.07);
    smooth_union(body, horn(p), 0.05)
}

/// The form with its carving: hair, beard, wrinkles.
pub fn carved(p: Vec3) -> f64 {
    let smooth = form(p);
    // The carving is shallow; far from the surface it does not matter.
    if smooth.abs() > 0.06 { smooth } else { smooth - relief(vec3(p.x.abs(), p.y, p.z)) }
}

fn skull(p: Vec3) -> f64 {
    let cranium = ellipsoid(p, vec3(0.0, 0.22, -0.12), vec3(0.42, 0.49, 0.50));
    let front = ellipsoid(p, vec3(0.0, -0.04, 0.16), vec3(0.33, 0.42, 0.33));
    let jaw = ellipsoid(p, vec3(0.0, -0.30, 0.20), vec3(0.24, 0.20, 0.25));
    smooth_union(smooth_union(cranium, front, 0.16), jaw, 0.12)
}

fn face(p: Vec3, skull: f64) -> f64 {
    let cheek = sphere(p, vec3(0.245, -0.035, 0.315), 0.105);
    let brow = tapered_capsule(p, vec3(0.045, 0.205, 0.445), vec3(0.30, 0.235, 0.30), (0.058, 0.045));
    let socket = ellipsoid(p, vec3(0.172, 0.085, 0.47), vec3(0.12, 0.078, 0.12));
    let bridge = tapered_capsule(p, vec3(0.0, 0.20, 0.455), vec3(0.0, -0.05, 0.585), (0.048, 0.062));
    let tip = ellipsoid(p, vec3(0.0, -0.065, 0.60), vec3(0.072, 0.062, 0.075));
    let wing = ellipsoid(p, vec3(0.07, -0.085, 0.535), vec3(0.045, 0.045, 0.06));
    let nostril = sphere(p, vec3(0.042, -0.128, 0.578), 0.022);
    let nose = smooth_union(smooth_union(bridge, tip, 0.06), wing, 0.04);
    let nose = smooth_subtraction(nose, nostril, 0.025);

    let mut form = smooth_union(skull, cheek, 0.12);
    form = smooth_union(form, brow, 0.07);
    form = smooth_subtraction(form, socket, 0.07);
    form = smooth_union(form, nose, 0.055);
    mouth(p, eyes(p, form))
}

/// Eyeballs between lids: the lids are parts of a shell round the ball, above and below the opening.
fn eyes(p: Vec3, form: f64) -> f64 {
    let ball = sphere(p, EYE, EYE_RADIUS);
    let shell = sphere(p, EYE, EYE_RADIUS + 0.017);
    let offset = p - EYE;
    // The opening is an almond: higher in the middle than at the corners.
    let arch = 0.026 * (1.0 - (offset.x / 0.09) * (offset.x / 0.09));
    let above = smooth_intersection(shell, 0.012 + arch - offset.y, 0.014);
    let below = smooth_intersection(shell, offset.y + 0.022 + 0.6 * arch, 0.014);
    let lids = smooth_union(above, below, 0.01);
    let form = smooth_union(form, lids, 0.022);
    let pupil = sphere(p, EYE + vec3(0.0, 0.004, EYE_RADIUS + 0.010), 0.024);
    let ball = smooth_subtraction(ball, pupil, 0.016);
    smooth_union(form, ball, 0.006)
}

fn mouth(p: Vec3, form: f64) -> f64 {
    let upper = tapered_capsule(p, vec3(0.0, -0.236, 0.478), vec3(0.125, -0.232, 0.385), (0.034, 0.018));
    let lower = tapered_capsule(p, vec3(0.0, -0.300, 0.462), vec3(0.105, -0.270, 0.385), (0.037, 0.020));
    let corner = vec3(0.155, -0.228, 0.375);
    let line = tapered_capsule(p, vec3(0.0, -0.268, 0.515), corner, (0.014, 0.010));
    let moustache = tapered_capsule(p, vec3(0.02, -0.185, 0.475), vec3(0.215, -0.275, 0.335), (0.036, 0.018));
    let lips = smooth_union(upper, lower, 0.02);
    let form = smooth_union(form, lips, 0.04);
    let form = smooth_subtraction(form, line, 0.018);
    smooth_union(form, moustache, 0.03)
}

fn beard(p: Vec3) -> f64 {
    let chin = tapered_capsule(p, vec3(0.0, -0.40, 0.33), vec3(0.0, -0.60, 0.44), (0.155, 0.105));
    let tip = tapered_capsule(p, vec3(0.0, -0.60, 0.44), vec3(0.0, -0.85, 0.55), (0.105, 0.022));
    let side = tapered_capsule(p, vec3(0.32, -0.10, 0.10), vec3(0.16, -0.42, 0.30), (0.055, 0.10));
    smooth_union(smooth_union(chin, tip, 0.06), side, 0.08)
}

/// Where a neck would begin: a soft rounding below the back of the head.
fn nape(p: Vec3) -> f64 {
    tapered_capsule(p, vec3(0.0, -0.15, -0.20), vec3(0.0, -0.42, -0.12), (0.27, 0.22))
}

/// A leaf: a flattened tapered tube with a hollow in its front.
fn ear(p: Vec3) -> f64 {
    let axis = EAR[1] - EAR[0];
    let along = ((p - EAR[0]).dot(axis) / axis.dot(axis)).clamp(0.0, 1.0);
    let offset = p - (EAR[0] + axis * along);
    let (up, front) = (vec3(-0.37, 0.93, 0.0), vec3(0.29, 0.12, 0.95));
    let swell = (4.0 * (along + 0.12) * (1.12 - along)).max(0.0) * (1.0 - along * 0.55);
    let width = EAR_WIDTH * swell + 0.012;
    let (u, f, a) = (offset.dot(up), offset.dot(front), offset.dot(axis.normalised()));
    let thick = 0.046;
    let leaf = ((u / width) * (u / width) + (f / thick) * (f / thick) + (a / width) * (a / width)).sqrt();
    let leaf = (leaf - 1.0) * thick;
    let (hollow_width, deep) = (width * 0.62, 0.030);
    let f = f - 0.054;
    let hollow = ((u / hollow_width) * (u / hollow_width) + (f / deep) * (f / deep)).sqrt() - 1.0;
    let hollow = hollow * deep + 0.10 * smoothstep(0.45, 1.0, along) + 0.08 * smoothstep(0.35, 0.0, along);
    smooth_subtraction(leaf, hollow, 0.05)
}

fn horn(p: Vec3) -> f64 {
    tapered_capsule(p, HORN[0], HORN[1], HORN_RADII)
}

/// Height of the carving over the form.
fn relief(p: Vec3) -> f64 {
    hair(p) + beard_strands(p) + wrinkles(p) + pores(p)
}

/// Waving grooves from the brow to the nape.
fn hair(p: Vec3) -> f64 {
    let line = 0.36 - 0.42 * smoothstep(0.30, -0.15, p.z) - 0.25 * smoothstep(-0.15, -0.5, p.z);
    let amount =
        smoothstep(line, line + 0.10, p.y) * smoothstep(0.60, 0.40, -p.y) * smoothstep(0.62, 0.50, p.x);
    let horns = smoothstep(0.14, 0.21, (p - HORN[0]).length());
    let around = p.x.atan2(0.25 - p.y * 0.2 + 0.35 * (p.z + 0.1).abs());
    let wave = 0.9 * (p.z * 9.0 + p.y * 5.0).sin();
    let strands = (around * 34.0 + wave * 1.6).sin();
    let fine = (around * 81.0 + wave * 3.1 + p.y * 12.0).sin();
    amount * horns * (0.012 * strands * (1.0 - 0.25 * strands) + 0.004 * fine + 0.012)
}

fn beard_strands(p: Vec3) -> f64 {
    let along = smoothstep(-0.30, -0.44, p.y) * smoothstep(-0.02, 0.20, p.z);
    let around = p.x.atan2(0.05 + (p.z - 0.28 + 0.35 * (p.y + 0.4)).max(0.0));
    let wave = 0.5 * (p.y * 15.0).sin() + 0.3 * (p.y * 27.0 + p.z * 9.0).sin();
    let strands = (around * 13.0 + wave * 1.3).sin();
    let fine = (around * 31.0 + wave * 2.9 + 1.0).sin();
    along * (0.010 * strands + 0.0035 * fine)
}

fn wrinkles(p: Vec3) -> f64 {
    let forehead = bell(p.y - 0.335, 0.10) * smoothstep(0.20, 0.34, p.z) * smoothstep(0.26, 0.14, p.x);
    let lines = ((p.y + 0.25 * p.x * p.x) * 105.0).sin();
    0.0042 * forehead * lines
}

/// A little unevenness, as of a thumb in clay.
fn pores(p: Vec3) -> f64 {
    let skin = smoothstep(-0.93, -0.80, p.y);
    let bumps = (p.x * 41.0 + 1.3).sin() * (p.y * 37.0).sin() * (p.z * 43.0 + 0.7).sin();
    let grain = (p.x * 97.0 + p.y * 31.0).sin() * (p.y * 89.0 - p.z * 23.0).sin() * (p.z * 101.0).sin();
    skin * (0.0016 * bumps + 0.0007 * grain)
}
