//! `zeronav swap` and `zeronav shadow`: exchange the process in a seat, or compare another with it.

use super::cli::StackArgs;
use crate::control::request::{Reply, Request};
use crate::running::{self, Running};
use crate::swap_order::SwapOrder;
use crate::swap_order::require::Clause;
use clap::Args;
use core::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use toml::Table;
use zeronav_console::arguments::{service_role, time_s};
use zeronav_console::exit::{EXIT_FAIL, EXIT_PASS};
use zeronav_console::interrupts::interrupts;
use zeronav_console::terminal::{complain, say, say_json_line, usage};
use zeronav_files::read;
use zeronav_measure::result::swap::SwapResult;
use zeronav_msgs::role::Role;
use zeronav_scenario::assignment::{assignment, lay_over};
use zeronav_scenario::{KEEP_S, SHADOW_S};
use zeronav_shell::printable;
use zeronav_supervise::binaries;

/// Between two questions about a swap.
const PAUSE: Duration = Duration::from_millis(100);

/// Between two lines about a swap.
const FEEDBACK: Duration = Duration::from_secs(1);

/// Unanswered questions after which the stack is taken to be gone.
const SILENCES_MAX: u32 = 5;

/// Which binary, and its configuration.
#[derive(Debug, Clone, Args)]
pub struct NewcomerArgs {
    /// Its seat.
    #[arg(value_name = "ROLE", value_parser = service_role, required_unless_present = "cancel")]
    pub role: Option<Role>,
    /// Its binary; without, the one that is in the seat.
    pub binary: Option<PathBuf>,
    /// TOML file with keys of its configuration. Those that are left out stay as they are when the
    /// binary is the same, and have their defaults when it is another.
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// One key of its configuration; may be given several times.
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub set: Vec<Table>,
    /// End the swap or comparison that goes on: the process that was in the seat before has it.
    #[arg(long, conflicts_with_all = ["role", "binary", "config", "set"])]
    pub cancel: bool,
}

/// Arguments of `zeronav swap`.
#[derive(Debug, Clone, Args)]
pub struct SwapArgs {
    /// The newcomer.
    #[command(flatten)]
    pub newcomer: NewcomerArgs,
    /// For how long it is compared before it is obeyed.
    #[arg(long, value_name = "TIME", value_parser = time_s, default_value_t = SHADOW_S)]
    pub shadow: f64,
    /// For how long its predecessor stays warm afterwards, to take over when it fails.
    #[arg(long, value_name = "TIME", value_parser = time_s, default_value_t = KEEP_S)]
    pub keep: f64,
    /// What it has to reach, such as `p99<2ms, agree>0.95`: times from wake to answer, and the share
    /// of ticks on which both agree.
    #[arg(long, value_name = "FIGURES")]
    pub require: Option<String>,
    /// Return at once; `zeronav status` says what becomes of it.
    #[arg(long)]
    pub no_wait: bool,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// Arguments of `zeronav shadow`.
#[derive(Debug, Clone, Args)]
pub struct ShadowArgs {
    /// The newcomer.
    #[command(flatten)]
    pub newcomer: NewcomerArgs,
    /// For how long; without, until Ctrl-C.
    #[arg(long = "for", value_name = "TIME", value_parser = time_s)]
    pub time: Option<f64>,
    /// What it has to reach, such as `p99<2ms, agree>0.95`; needs `--for`.
    #[arg(long, value_name = "FIGURES", requires = "time")]
    pub require: Option<String>,
    /// The stack.
    #[command(flatten)]
    pub stack: StackArgs,
}

/// `zeronav swap`.
#[must_use]
pub fn swap(arguments: &SwapArgs) -> ExitCode {
    let SwapArgs { stack, .. } = arguments;
    if arguments.newcomer.cancel {
        return cancel(stack);
    }
    let (shadow_s, keep_s) = (Some(arguments.shadow), Some(arguments.keep));
    let require = arguments.require.as_deref();
    let order = order(&arguments.newcomer, shadow_s, keep_s, require);
    send(order, stack, arguments.no_wait, false)
}

/// `zeronav shadow`.
#[must_use]
pub fn shadow(arguments: &ShadowArgs) -> ExitCode {
    let ShadowArgs { stack, time, .. } = arguments;
    if arguments.newcomer.cancel {
        return cancel(stack);
    }
    let require = arguments.require.as_deref();
    let order = order(&arguments.newcomer, *time, None, require);
    send(order, stack, false, true)
}

fn cancel(arguments: &StackArgs) -> ExitCode {
    let asked = running::find(arguments.domain.as_deref())
        .and_then(|stack| Ok(stack.ask(&Request::SwapCancel)?));
    match asked {
        Ok(_) => {
            say("cancelled\n");
            ExitCode::from(EXIT_PASS)
        }
        Err(problem) => usage(&problem),
    }
}

fn order(
    newcomer: &NewcomerArgs,
    shadow_s: Option<f64>,
    keep_s: Option<f64>,
    require: Option<&str>,
) -> Result<SwapOrder, String> {
    let role = newcomer.role.ok_or("the seat is missing")?;
    let mut config = Table::new();
    if let Some(file) = &newcomer.config {
        let problem = |error: &dyn core::fmt::Display| format!("{}: {error}", file.display());
        let text = read::text(file, read::TEXT_BYTES_MAX).map_err(|error| problem(&error))?;
        config = toml::from_str(&text).map_err(|error| problem(&error))?;
    }
    for keys in &newcomer.set {
        lay_over(&mut config, keys.clone());
    }
    // A name is looked up by launch, or by the other host.
    let is_path = |binary: &&PathBuf| binary.components().count() > 1;
    let binary = match newcomer.binary.as_ref() {
        Some(path) if is_path(&path) => Some(binaries::find(path)?),
        name => name.cloned(),
    };
    let order = SwapOrder {
        role: role.to_string(),
        binary,
        config,
        shadow_s,
        keep_s,
        require: require.map_or(Ok(Vec::new()), Clause::parse_all)?,
    };
    order.check()?;
    Ok(order)
}

fn send(
    order: Result<SwapOrder, String>,
    arguments: &StackArgs,
    no_wait: bool,
    ends_with_us: bool,
) -> ExitCode {
    let begun = order.and_then(|order| {
        let stack = running::find(arguments.domain.as_deref())?;
        let result = ask(&stack, &Request::Swap { order })?;
        Ok((stack, result))
    });
    let (stack, result) = match begun {
        Ok(begun) => begun,
        Err(problem) => return usage(&problem),
    };
    tell(&result, arguments.json);
    if no_wait {
        return ExitCode::from(EXIT_PASS);
    }
    follow(&stack, result, arguments.json, ends_with_us)
}

/// Says how a swap gets on until it is over. A comparison ends with the command that asked for it.
fn follow(stack: &Running, mut result: SwapResult, json: bool, ends_with_us: bool) -> ExitCode {
    let interrupted = match interrupts() {
        Ok(interrupted) => interrupted,
        Err(problem) => return usage(&problem),
    };
    let (id, mut told, mut silences) = (result.id, Instant::now(), 0);
    while !result.is_over() {
        std::thread::sleep(PAUSE);
        if interrupted.swap(false, Ordering::Relaxed) {
            if !ends_with_us {
                say("the swap goes on; `zeronav status` says what becomes of it\n");
                return ExitCode::from(zeronav_console::exit::EXIT_INTERRUPTED);
            }
            let _ = stack.ask(&Request::SwapCancel);
        }
        let before = result.state.clone();
        match ask(stack, &Request::SwapStatus { id: Some(id) }) {
            Ok(newest) => (result, silences) = (newest, 0),
            Err(problem) => {
                silences += 1;
                if silences > SILENCES_MAX || !stack.root().exists() {
                    complain(&format!("swap {id}: the stack ended first; {problem}"));
                    return ExitCode::from(EXIT_FAIL);
                }
            }
        }
        if result.state != before || told.elapsed() >= FEEDBACK {
            told = Instant::now();
            tell(&result, json);
        }
    }
    ExitCode::from(match result.state.as_str() {
        "swapped" | "compared" => EXIT_PASS,
        _ => EXIT_FAIL,
    })
}

fn ask(stack: &Running, request: &Request) -> Result<SwapResult, String> {
    match stack.ask(request)? {
        Reply::Swap(result) => Ok(*result),
        other => Err(stack.refusal(&format!("an unexpected answer: {other:?}"))),
    }
}

fn tell(result: &SwapResult, json: bool) {
    if json {
        say_json_line(result);
    } else {
        say(&in_words(result));
    }
}

/// One line while it goes on, a table at its end.
pub(super) fn in_words(result: &SwapResult) -> String {
    let (id, found) = (result.id, &result.comparison);
    let mut text = format!(
        "swap {id}: {}, {}: {}",
        result.role,
        printable(&result.binary),
        printable(&result.state)
    );
    if let Some(why) = &result.why {
        let _ = write!(text, ": {}", printable(why));
    }
    if let Some(agree) = found.agree {
        let _ = write!(text, ", agree {agree:.3} over {} ticks", found.ticks);
    }
    text.push('\n');
    if !result.is_over() {
        return text;
    }
    let ticks = [
        ("obeyed from tick", result.cut_over_tick),
        ("given back from tick", result.roll_back_tick),
    ];
    for (name, tick) in ticks {
        if let Some(tick) = tick {
            let _ = writeln!(text, "  {name:<28} {tick}");
        }
    }
    let _ = writeln!(
        text,
        "  {:<28} {}",
        "command_gap_ticks", result.command_gap_ticks
    );
    for (name, value) in &found.measures {
        let _ = writeln!(text, "  {name:<28} {value:.3}");
    }
    for (name, times) in [("incumbent", &found.office), ("newcomer", &found.newcomer)] {
        if let (Some(p50_us), Some(p99_us)) = (times.p50_us, times.p99_us) {
            let n = times.n;
            let _ = writeln!(
                text,
                "  {name:<28} p50 {p50_us:.0} us, p99 {p99_us:.0} us, n {n}"
            );
        }
    }
    text
}
