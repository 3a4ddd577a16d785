//! The files of the page, as text.

/// `ZeronavScene`: keeps frames and draws a moment of them. A classic script.
pub const SCENE_JS: &str = include_str!("../page/scene.js");
