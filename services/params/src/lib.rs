//! Parameters of a service, each declared once: name, type, default, range, unit and a sentence.
//!
//! [`parameters!`] makes the struct that serde reads and writes, its `Default` and [`Parameters`],
//! from which come the range check ([`check`]) and the description of all parameters
//! ([`describe`]) that `--print-params`, the reference tables and the JSON schema show.
//! [`choices!`] makes an enum whose variants are the allowed values of a string.
//!
//! ```
//! zeronav_params::choices! {
//!     /// What happens at the edge of the map.
//!     pub enum Edge {
//!         /// The map stays.
//!         #[default]
//!         Fixed = "fixed",
//!         /// The map moves along.
//!         Rolling = "rolling",
//!     }
//! }
//! zeronav_params::parameters! {
//!     /// The window of the map.
//!     pub struct Window {
//!         /// What happens at the edge.
//!         edge: Edge = Edge::Fixed;
//!         /// Distance from the edge at which the map moves.
//!         margin_m: f64 = 3.0, [0.0, 10.0] "m";
//!         /// Side of the map.
//!         side_m: f64 = 20.0, [1.0, 100.0] "m";
//!     }
//!     relations |own| {
//!         margin_m: own.margin_m < 0.5 * own.side_m, "must be less than half of side_m";
//!     }
//! }
//! zeronav_params::parameters! {
//!     /// A service.
//!     pub struct Config {
//!         /// The window.
//!         window: Window;
//!     }
//! }
//!
//! let mut config = Config::default();
//! assert_eq!(zeronav_params::check(&config), Ok(()));
//! config.window.side_m = 4.0;
//! let error = zeronav_params::check(&config).unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "window.margin_m must be less than half of side_m, not 3.0"
//! );
//! let paths: Vec<_> = zeronav_params::describe::<Config>()
//!     .into_iter()
//!     .map(|parameter| parameter.path)
//!     .collect();
//! assert_eq!(paths, ["window.edge", "window.margin_m", "window.side_m"]);
//! ```

mod declare;
mod parameter;
mod setting;
mod value;

pub use parameter::{Parameter, ParameterError, Relation};
pub use setting::Setting;
pub use value::{Choice, Type, Value};

/// A struct of parameters and groups of parameters, as [`parameters!`] makes it.
pub trait Parameters {
    /// Visits every parameter with its value, in the order of declaration. `path` is that of the
    /// group, empty for the whole configuration.
    fn visit(&self, path: &str, visitor: &mut dyn FnMut(Parameter));
}

/// Every parameter of a configuration with its default.
#[must_use]
pub fn describe<P: Parameters + Default>() -> Vec<Parameter> {
    let mut parameters = Vec::new();
    P::default().visit("", &mut |parameter| parameters.push(parameter));
    parameters
}

/// Accepts a configuration whose numbers are finite and within their ranges and whose relations
/// hold. Relations are checked after all ranges.
///
/// # Errors
/// The first parameter that is out of its range, else the first relation that does not hold.
pub fn check<P: Parameters>(config: &P) -> Result<(), ParameterError> {
    let (mut range, mut relation) = (None, None);
    config.visit("", &mut |parameter| {
        range = range.take().or_else(|| parameter.out_of_range());
        relation = relation.take().or_else(|| parameter.broken_relation());
    });
    range.or(relation).map_or(Ok(()), Err)
}
