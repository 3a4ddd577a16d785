//! The arguments of `zeronav top`.

use crate::remote::cli::StackArgs;
use clap::Args;

/// Arguments of `zeronav top`.
#[derive(Debug, Clone, Args)]
pub struct TopArgs {
    /// Print one sample of a second and end, as without a terminal.
    #[arg(long)]
    pub once: bool,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}
