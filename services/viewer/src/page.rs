//! The files of the page, as text.

/// `ZeronavScene`: keeps frames and draws a moment of them. A classic script.
pub const SCENE_JS: &str = include_str!("../page/scene.js");

/// `ZeronavPlayer`: moves through the time of a scene. A classic script, behind [`SCENE_JS`].
pub const PLAYER_JS: &str = include_str!("../page/player.js");

/// The live page.
pub const INDEX_HTML: &str = include_str!("../page/index.html");

/// What the live page asks of the stack, and what became of it.
pub const ACTS_JS: &str = include_str!("../page/acts.js");

/// Receives frames, and shows tables and time line of the live page.
pub const LIVE_JS: &str = include_str!("../page/live.js");

/// How the live page looks.
pub const STYLE_CSS: &str = include_str!("../page/style.css");
