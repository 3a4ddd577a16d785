//! The controllers of the papers. Keys, equations and corrections are those of the paper notes:
//! [JU] Ju, Luo, Yan: APF + A* fusion; [ZM] Zhang & Meng 2022: A* optimised with an improved APF;
//! [LWX] Liu, Wang, Xu 2022: optimised A* + APF + least squares; [BAO] Bao et al. 2023: improved
//! A* with virtual obstacles and DWA.
//!
//! A potential-field method is a [`Law`]: from a [`LawInput`] to a direction. [`walk`] rolls it out
//! in the plane, as the papers do; [`drive`] drives along it as a chooser of the pilot, and
//! [`bao_window`] is that of [`bao_dwa`].

pub mod bao_dwa;
pub mod bao_window;
pub mod drive;
mod escape;
pub mod fit;
pub mod ju_apf;
pub mod ju_fusion;
pub mod ju_r6;
pub mod ju_r7;
pub mod law;
pub mod lwx_fusion;
pub mod lwx_loop;
pub mod lwx_lsq;
pub mod lwx_oapf;
pub mod options;
mod pieces;
pub mod potential;
pub mod route;
pub mod walk;
pub mod zm_esc;
pub mod zm_full;
pub mod zm_rep;
pub mod zm_rv;

pub use law::{Body, Extent, Ground, Law, LawInput, Push};
