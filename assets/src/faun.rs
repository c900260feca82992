//! The faun's head as a signed distance field: skull, face, ears, horns, neck and bust, blended smoothly.
//!
//! Guarantees: mirror-symmetric in x; one connected solid of genus 0 that fits in a box about two units high. `openness` fades
//! in what is hard to reach from a coarse mesh (lids, lips, nostrils), so a mesh can be led to it level by level.
//!
//! Non-guarantees: hair, wrinkles and horn rings are not here; [`crate::carving`] cuts them into the finest mesh.

use crate::distance_field::{
    bell, ellipsoid, smooth_intersection, smooth_subtraction, smooth_union, smoothstep, tapered_capsule,
};
use crate::vector::{Vec3, vec3};

/// The middle of the model's left eyeball.
pub const EYE: Vec3 = vec3(0.165, 0.080, 0.308);
/// Its radius.
pub const EYE_RADIUS: f64 = 0.108;
/// How far the lids stand over it.
const LID_THICKNESS: f64 = 0.018;
/// Where the left eye looks: forwards, a little outwards and up.
const GAZE: Vec3 = vec3(0.10, 0.06, 0.993);
/// Distance of the horn's root from its tip along the arc, as an angle.
const HORN_SWEEP: f64 = 1.85;
const HORN_ARC_RADIUS: f64 = 0.37;
const HORN_ROOT: Vec3 = vec3(0.185, 0.50, 0.19);
const EAR_ROOT: Vec3 = vec3(0.385, 0.07, -0.07);
const EAR_LENGTH: f64 = 0.50;

/// The signed distance to the head at `p`. `openness` 0 leaves eyes, mouth and nostrils closed lumps; 1 is all of it.
pub fn head(p: Vec3, openness: f64) -> f64 {
    // A soft |x|: features by the middle meet their mirror images without a crease.
    let q = vec3((p.x * p.x + 1e-4).sqrt(), p.y, p.z);
    let mut d = skull(q);
    d = smooth_union(d, neck_and_bust(q), 0.16);
    d = face(q, d, openness);
    d = smooth_union(d, horn(q, openness), 0.05);
    smooth_union(d, ear(q, openness), 0.06)
}

/// How far `p` lies inside the hair: positive behind the hairline, in model units.
pub fn behind_hairline(p: Vec3) -> f64 {
    let peak = 0.05 * bell(p.x, 0.13) - 0.05 * bell(p.x.abs() - 0.20, 0.13);
    0.56 * (p.y - 0.47) - 0.83 * (p.z - 0.345) + peak
}

fn skull(q: Vec3) -> f64 {
    let cranium = ellipsoid(q, vec3(0.0, 0.20, -0.09), vec3(0.425, 0.455, 0.485));
    // Hair lies on the skull as a thick cap that thins out towards the hairline and the neck.
    let hair = 0.035 * smoothstep(-0.03, 0.10, behind_hairline(q)) * smoothstep(-0.5, -0.25, q.y);
    let jaw = ellipsoid(q, vec3(0.0, -0.13, 0.06), vec3(0.335, 0.40, 0.37));
    smooth_union(cranium - hair, jaw, 0.14)
}

fn neck_and_bust(q: Vec3) -> f64 {
    let neck = tapered_capsule(q, vec3(0.0, -0.25, -0.17), vec3(0.0, -0.85, -0.14), (0.25, 0.26));
    let tendon = tapered_capsule(q, vec3(0.29, -0.20, -0.12), vec3(0.055, -0.80, 0.13), (0.05, 0.04));
    let shoulders = ellipsoid(q, vec3(0.0, -1.0, -0.11), vec3(0.56, 0.27, 0.36));
    let d = smooth_union(smooth_union(neck, tendon, 0.07), shoulders, 0.16);
    smooth_intersection(d, -1.0 - q.y, 0.09)
}

fn face(q: Vec3, mut d: f64, openness: f64) -> f64 {
    // Cheekbones, and the apples of smiling cheeks; the muzzle; the forehead.
    d = smooth_union(d, ellipsoid(q, vec3(0.265, -0.03, 0.250), vec3(0.125, 0.085, 0.12)), 0.14);
    d = smooth_union(d, ellipsoid(q, vec3(0.195, -0.115, 0.325), vec3(0.105, 0.090, 0.100)), 0.10);
    d = smooth_union(d, ellipsoid(q, vec3(0.0, -0.265, 0.335), vec3(0.185, 0.13, 0.15)), 0.12);
    d = smooth_union(d, ellipsoid(q, vec3(0.0, 0.36, 0.27), vec3(0.26, 0.15, 0.13)), 0.12);
    d = eye_and_brow(q, d, openness);
    d = smooth_union(d, beard(q), 0.07);
    d = nose(q, d, openness);
    mouth(q, d, openness)
}

fn eye_and_brow(q: Vec3, mut d: f64, openness: f64) -> f64 {
    let socket = ellipsoid(q, EYE + vec3(0.006, 0.0, 0.112), vec3(0.128, 0.092, 0.082));
    d = smooth_subtraction(d, socket, 0.12);
    d = smooth_union(d, brow(q), 0.07);

    let offset = q - EYE;
    let reach = offset.length();
    let direction = offset * (1.0 / reach.max(1e-6));
    let gaze = GAZE.normalised();
    let side = vec3(gaze.z, 0.0, -gaze.x).normalised();
    let (across, up) = (direction.dot(side), direction.dot(gaze.cross(side)));
    // The almond between the lids, in directions from the eye's middle; its outer corner sits higher.
    let (t, tilted) = (across / 0.84, up - 0.10 * across);
    let room = (1.0 - t * t).max(-1.0);
    let gap = (0.50 * room - tilted).min(tilted + 0.40 * room) * reach;
    let open = if direction.dot(gaze) > 0.0 { gap } else { -0.1 };
    let shell = reach - EYE_RADIUS - LID_THICKNESS;
    let lid = smooth_intersection(shell, open - 0.2 * (1.0 - openness), 0.022);
    // A crease above the upper lid.
    let crease = 0.008 * openness * bell(tilted - 0.50 * room - 0.24, 0.14) * bell(across, 0.9);
    d = smooth_union(d, lid + crease, 0.05);
    smooth_union(d, eyeball(reach, direction, gaze, openness), 0.010)
}

/// A brow that climbs from a kindly raised inner end and comes down outside.
pub fn brow(q: Vec3) -> f64 {
    let inner = tapered_capsule(q, vec3(0.060, 0.232, 0.425), vec3(0.19, 0.278, 0.395), (0.036, 0.046));
    let outer = tapered_capsule(q, vec3(0.19, 0.278, 0.395), vec3(0.335, 0.205, 0.245), (0.046, 0.028));
    smooth_union(inner, outer, 0.05)
}

/// The eyeball with its iris sunk and its pupil drilled, as marble eyes are, a catch-light left standing.
fn eyeball(reach: f64, direction: Vec3, gaze: Vec3, openness: f64) -> f64 {
    let off_axis = (direction - gaze * direction.dot(gaze)).length();
    if direction.dot(gaze) < 0.0 {
        return reach - EYE_RADIUS;
    }
    let iris = smoothstep(0.50, 0.38, off_axis);
    let pupil = smoothstep(0.28, 0.12, off_axis);
    let light = bell((direction - gaze - vec3(-0.09, 0.14, 0.0)).length(), 0.17);
    reach - EYE_RADIUS + openness * (0.008 * iris + 0.024 * pupil - 0.018 * light)
}

fn nose(q: Vec3, mut d: f64, openness: f64) -> f64 {
    let bridge = tapered_capsule(q, vec3(0.0, 0.20, 0.395), vec3(0.0, -0.01, 0.535), (0.046, 0.064));
    let tip = ellipsoid(q, vec3(0.0, -0.060, 0.560), vec3(0.092, 0.074, 0.085));
    let wing = ellipsoid(q, vec3(0.090, -0.083, 0.480), vec3(0.054, 0.050, 0.068));
    d = smooth_union(d, bridge, 0.10);
    d = smooth_union(d, smooth_union(tip, wing, 0.04), 0.05);
    let nostril = ellipsoid(q, vec3(0.050, -0.130, 0.530), vec3(0.026, 0.028, 0.036));
    smooth_subtraction(d, nostril + 0.03 * (1.0 - openness), 0.025)
}

fn mouth(q: Vec3, mut d: f64, openness: f64) -> f64 {
    // Measured along the smile: it rises towards the corners and bends back round the teeth.
    let x = q.x;
    let smile = vec3(x, q.y + 0.285 - 1.8 * x * x, q.z - 0.478 + 2.2 * x * x);
    let bow = vec3(0.0, 0.008 * bell(x - 0.035, 0.06) - 0.006 * bell(x, 0.03), 0.0);
    let upper =
        tapered_capsule(smile - bow, vec3(0.0, 0.022, -0.002), vec3(0.155, 0.006, -0.010), (0.031, 0.010));
    let lower =
        tapered_capsule(smile, vec3(0.0, -0.030, -0.002), vec3(0.135, -0.022, -0.014), (0.038, 0.012));
    d = smooth_union(d, upper, 0.030);
    d = smooth_union(d, lower, 0.035);
    // The line between the lips, ending in a dimple, and the folds of the smile.
    let slit = tapered_capsule(smile, vec3(0.0, -0.003, 0.030), vec3(0.185, 0.006, 0.014), (0.010, 0.013));
    d = smooth_subtraction(d, slit + 0.03 * (1.0 - openness), 0.022);
    let fold = tapered_capsule(q, vec3(0.145, -0.080, 0.510), vec3(0.250, -0.270, 0.400), (0.006, 0.006));
    smooth_subtraction(d, fold, 0.07)
}

/// Chin, goatee and a fringe along the jaw.
pub fn beard(q: Vec3) -> f64 {
    let x = (q.x * q.x + 1e-4).sqrt();
    let q = vec3(x, q.y, q.z);
    let chin = ellipsoid(q, vec3(0.0, -0.465, 0.36), vec3(0.155, 0.10, 0.125));
    let upper = tapered_capsule(q, vec3(0.0, -0.47, 0.36), vec3(0.0, -0.68, 0.425), (0.135, 0.085));
    let lower = tapered_capsule(q, vec3(0.0, -0.68, 0.425), vec3(0.0, -0.83, 0.515), (0.085, 0.022));
    let fringe = tapered_capsule(q, vec3(0.36, -0.02, 0.045), vec3(0.285, -0.30, 0.13), (0.05, 0.075));
    let jaw = tapered_capsule(q, vec3(0.285, -0.30, 0.13), vec3(0.10, -0.47, 0.33), (0.075, 0.10));
    let goatee = smooth_union(smooth_union(upper, lower, 0.05), chin, 0.05);
    smooth_union(goatee, smooth_union(fringe, jaw, 0.05), 0.06)
}

/// The horn's own frame: the direction it starts in, the way it bends, and its side.
fn horn_frame() -> (Vec3, Vec3, Vec3) {
    let start = vec3(0.30, 0.92, 0.26).normalised();
    let bend = vec3(0.10, 0.05, -1.0).without(start).normalised();
    (start, bend, start.cross(bend))
}

fn horn_radius(along: f64) -> f64 {
    0.112 * (1.0 - 0.80 * along) + 0.018 * bell(along, 0.25)
}

/// A point on the horn: `along` from 0 (root) to 1 (tip), off its axis by `front` and `side` radii.
pub fn horn_point(along: f64, front: f64, side: f64) -> Vec3 {
    let (start, bend, across) = horn_frame();
    let angle = along * HORN_SWEEP;
    let along = along.min(1.0);
    let outwards = start * angle.sin() - bend * angle.cos();
    let axis = HORN_ROOT + bend * HORN_ARC_RADIUS + outwards * HORN_ARC_RADIUS;
    let across = if across.x < 0.0 { -across } else { across };
    axis + outwards * (front * horn_radius(along)) + across * (side * horn_radius(along))
}

/// Where `q` lies along the horn (0 root, 1 tip) and how far from its axis; `q.x` is taken as positive.
pub fn along_horn(q: Vec3) -> (f64, f64) {
    let (start, bend, across) = horn_frame();
    let offset = q - HORN_ROOT - bend * HORN_ARC_RADIUS;
    let (forth, back) = (offset.dot(start), -offset.dot(bend));
    let angle = forth.atan2(back).clamp(-0.25, HORN_SWEEP);
    let on_arc = vec3(angle.sin(), angle.cos(), 0.0) * HORN_ARC_RADIUS;
    let away = vec3(forth - on_arc.x, back - on_arc.y, offset.dot(across));
    (angle / HORN_SWEEP, away.length())
}

/// Thicker at its tip while the mesh is coarse, and so is the ear: midpoints of coarse edges must not cut through.
fn horn(q: Vec3, openness: f64) -> f64 {
    let (along, away) = along_horn(q);
    away - horn_radius(along) - 0.015 * (1.0 - openness) * along.max(0.0)
}

/// The ear's own frame: out along it, up across it, and forwards through it.
fn ear_frame() -> (Vec3, Vec3, Vec3) {
    let out = vec3(0.90, 0.16, -0.40).normalised();
    let forwards = vec3(0.42, -0.05, 0.90).without(out).normalised();
    (out, forwards.cross(out), forwards)
}

/// Half the ear's width and thickness, and how far it sags and bends back, at `along`.
fn ear_profile(along: f64) -> (f64, f64, f64, f64) {
    let s = along.clamp(0.0, 1.0);
    let leaf = (s + 0.16) * (1.0 - s) * (1.0 - 0.35 * s);
    let width = 0.026 + 0.40 * leaf;
    (width, 0.018 + 0.038 * (1.0 - s), 0.13 * s * s - 0.10 * s, 0.05 * s * s)
}

/// A point on the ear: `along` from 0 (root) to 1 (tip), off its axis by `up` half widths and `front` half thicknesses.
pub fn ear_point(along: f64, up: f64, front: f64) -> Vec3 {
    let (out, upwards, forwards) = ear_frame();
    let (width, thickness, rise, back) = ear_profile(along);
    EAR_ROOT
        + out * (along * EAR_LENGTH)
        + upwards * (rise + up * width)
        + forwards * (front * thickness - back)
}

/// Where `q` lies in the ear's frame: along it, across in half widths, and through it in model units.
pub fn in_ear(q: Vec3) -> (f64, f64, f64) {
    let (out, upwards, forwards) = ear_frame();
    let offset = q - EAR_ROOT;
    let along = offset.dot(out) / EAR_LENGTH;
    let (width, _, rise, back) = ear_profile(along);
    (along, (offset.dot(upwards) - rise) / width, offset.dot(forwards) + back)
}

/// Distance to the ear, to first order across it and underestimated along its width; thicker while `openness` is small.
pub fn ear(q: Vec3, openness: f64) -> f64 {
    let (along, across, through) = in_ear(q);
    let thickness = ear_profile(along).1 * (1.9 - 0.9 * openness);
    // Curled like a leaf: the rims come forwards, the middle goes back.
    let curl = (0.35 + 0.65 * openness) * 0.075 * (across * across).min(1.4) - 0.02;
    let through = (through - curl * smoothstep(1.0, 0.35, along)) / thickness;
    let beyond = (along - along.clamp(-0.1, 1.0)) * EAR_LENGTH;
    let flat = ((across * across + through * through).sqrt() - 1.0) * thickness;
    if beyond == 0.0 { flat } else { flat.max(0.0).hypot(beyond) + flat.min(0.0) }
}

/// Whether `p` lies on a horn, an ear, the nose or the beard's tip: limbs that a coarse mesh meets with few vertices.
pub fn on_limb(p: Vec3) -> bool {
    let q = vec3(p.x.abs(), p.y, p.z);
    let (along_horn, away) = along_horn(q);
    let (along_ear, _, _) = in_ear(q);
    (along_horn > 0.12 && away < 0.16)
        || (along_ear > 0.12 && q.x > 0.42)
        || (q.y < -0.58 && q.z > 0.25)
        || q.z > 0.57
}

/// Relative edge length wanted at `p`: fine on the face, most of all round eyes, nose and mouth, and at the tips that a
/// relaxation tends to leave bare; coarse below the bust.
pub fn spacing(p: Vec3) -> f64 {
    let q = vec3(p.x.abs(), p.y, p.z);
    let near = |centre: Vec3, reach: f64| bell((q - centre).length(), reach);
    let front = smoothstep(0.10, 0.34, q.z) * smoothstep(-0.50, -0.35, q.y) * smoothstep(0.55, 0.45, q.y);
    let face = (2.8 * near(EYE + vec3(0.0, 0.02, 0.08), 0.27))
        .max(1.7 * near(vec3(0.07, -0.27, 0.46), 0.26))
        .max(1.5 * near(vec3(0.04, -0.09, 0.55), 0.24))
        .max(1.9 * near(vec3(0.20, 0.25, 0.38), 0.20))
        .max(0.9 * front);
    let tips = near(horn_point(1.0, 0.0, 0.0), 0.28)
        .max(near(ear_point(1.0, 0.0, 0.0), 0.28))
        .max(near(vec3(0.0, -0.80, 0.50), 0.30));
    let below = 0.8 * smoothstep(-0.93, -0.98, p.y);
    (1.0 + below) / (1.0 + face.max(1.6 * tips))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_is_symmetric_and_finite() {
        for p in [vec3(0.3, 0.2, 0.4), vec3(0.7, 0.1, -0.2), vec3(0.0, -0.6, 0.4), vec3(0.165, 0.080, 0.308)]
        {
            assert_eq!(head(p, 1.0), head(p.mirrored(), 1.0));
            assert!(head(p, 0.5).is_finite());
        }
    }

    #[test]
    fn horns_and_ears_hold_their_own_points() {
        for along in [0.2, 0.5, 0.8] {
            assert!(head(horn_point(along, 0.0, 0.0), 1.0) < 0.0, "horn at {along}");
            assert!(head(ear_point(along, 0.0, 0.0), 0.0) < 0.02, "ear at {along}");
        }
        assert!(head(vec3(0.0, 1.2, 0.0), 1.0) > 0.0);
    }
}
