//! What is drawn over the surface, and how all of it looks.
//!
//! Colours are sRGB bytes; a fourth byte is straight opacity. Widths and radii are in points: pixels times
//! [`Style::scale`].

/// How finely edges of triangles are smoothed. Lines and handles are smooth either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Samples {
    /// One sample a pixel: jagged silhouettes, and several times faster without a GPU.
    One,
    /// Four samples a pixel.
    #[default]
    Four,
}

impl Samples {
    /// Samples per pixel.
    pub fn count(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }
}

/// How the surface is lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shading {
    /// Warm modelling clay: soft key light from the upper left, a cool rim.
    #[default]
    Clay,
    /// Glazed pale porcelain: brighter, with a clear highlight that shows ripples.
    Porcelain,
    /// World-space normals as colours.
    Normals,
    /// Clay with one normal per triangle: shows the faces themselves.
    Flat,
}

/// What lies behind the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// A calm dark neutral gradient, for work.
    #[default]
    Dark,
    /// Near-white, for documents.
    Light,
}

impl Background {
    /// Colours at the top and at the bottom of the picture.
    pub(super) fn gradient(self) -> [[u8; 4]; 2] {
        match self {
            Self::Dark => [[64, 66, 71, 255], [30, 31, 34, 255]],
            Self::Light => [[250, 250, 249, 255], [222, 223, 225, 255]],
        }
    }
}

/// How a family of lines looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineStyle {
    /// Colour and opacity.
    pub color: [u8; 4],
    /// Width in points.
    pub width: f32,
    /// Opacity of what lies behind the surface, as a fraction of the visible; 0 hides it.
    pub hidden: f32,
}

/// How the ghost mesh looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GhostStyle {
    /// Colour and opacity of its faces seen straight on; grazing faces are denser.
    pub fill: [u8; 4],
    /// Its edges.
    pub edges: LineStyle,
}

/// The look of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// How the surface is lit.
    pub shading: Shading,
    /// Whether the inside shows where the surface is open. Without it a closed surface looks the same and draws
    /// up to twice as fast.
    pub two_sided: bool,
    /// What lies behind it.
    pub background: Background,
    /// Darkening of hollows and brightening of ridges, 0 (none) to 1.
    pub cavity: f32,
    /// The level's edges on the surface.
    pub edges: LineStyle,
    /// Opacity of free lines where they lie behind the surface, as a fraction of their own.
    pub lines_hidden: f32,
    /// Opacity of handles behind the surface, as a fraction of their own; 0 hides them.
    pub handles_hidden: f32,
    /// The control polyhedron.
    pub ghost: GhostStyle,
    /// Pixels per point. The window sets it; a picture made without one may use it to keep lines visible when
    /// large.
    pub scale: f32,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            shading: Shading::Clay,
            two_sided: true,
            background: Background::Dark,
            cavity: 0.5,
            edges: LineStyle { color: [26, 20, 18, 150], width: 1.2, hidden: 0.0 },
            lines_hidden: 0.25,
            handles_hidden: 0.0,
            ghost: GhostStyle {
                fill: [122, 176, 224, 24],
                edges: LineStyle { color: [158, 203, 240, 210], width: 1.2, hidden: 0.18 },
            },
            scale: 1.0,
        }
    }
}

/// A line through space, such as an axis, a support's outline, or a link from a handle to its control point.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Line {
    /// One end.
    pub from: [f32; 3],
    /// The other.
    pub to: [f32; 3],
    /// Colour and opacity.
    pub color: [u8; 4],
    /// Width in points.
    pub width: f32,
}

/// What the hand is doing with a handle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HandleState {
    /// Nothing.
    #[default]
    Idle,
    /// The cursor is over it: a little larger, with a halo.
    Hovered,
    /// It is the one being edited: larger still, with a ring around it.
    Selected,
}

/// A disc of constant size on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handle {
    /// Its centre, model units.
    pub position: [f32; 3],
    /// Radius in points when idle, rim included.
    pub radius: f32,
    /// Inside colour and opacity.
    pub fill: [u8; 4],
    /// Rim colour and opacity.
    pub rim: [u8; 4],
    /// What the hand is doing with it.
    pub state: HandleState,
}
