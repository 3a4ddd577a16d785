//! `zeronav`: see `zeronav --help`.

#![warn(clippy::print_stderr)]

use clap::Parser;
use clap::error::ErrorKind;
use std::process::ExitCode;
use zeronav::bag::diff;
use zeronav::cli::{Cli, Command};
use zeronav::live_view;
use zeronav::new_package;
use zeronav::remote::{fault, goal, swap, verbs, zone};
use zeronav::show::log;
use zeronav::{
    algorithms, background_load, bag, bisect, check, command_start, commands, compare, completions,
    debug, doctor, host, import, latency, list, logs, map_save, params, picture, recordings,
    remote, replay, report, start_up, top, topics, view_recording, why,
};
use zeronav_console::exit::EXIT_USAGE;
use zeronav_console::{arguments, terminal};
use zeronav_contract_kit::no_memory;
use zeronav_msgs::role::Role;
use zeronav_shell::flags::one_line;
use zeronav_supervise::{cleaner, warden, will};

// long: a line for each verb
fn main() -> ExitCode {
    command_start::note();
    let cli = match command_line() {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    if let Command::Clean { root } = &cli.command {
        return ExitCode::from(u8::from(!cleaner::run(root)));
    }
    if matches!(cli.command, Command::Warden) {
        warden::run();
        return ExitCode::SUCCESS;
    }
    if let Command::Busy { limit_s } = cli.command {
        background_load::compute(limit_s);
        return ExitCode::SUCCESS;
    }
    if let Command::WithoutMemory(arguments) = &cli.command {
        return no_memory::contract_without_memory(arguments);
    }
    zeronav_console::interrupts::survive_file_limit();
    warden::enable();
    will::settle_when_fatal();
    log::start();
    // Whatever a killed run has left is removed by the next command, whichever it is; the doctor
    // does it itself.
    if !matches!(cli.command, Command::Doctor(_)) {
        for root in zeronav_shell::domain::sweep_dead() {
            tracing::info!(root = %root.display(), "removed the domain of a run that was killed");
        }
    }
    terminal::settle(match cli.command {
        Command::Run(arguments) => commands::run(&arguments.plan(), arguments.start.output.json),
        Command::Latency(arguments) => latency::latency(&arguments),
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::StartUp(arguments) => start_up::start_up(&arguments),
        Command::Up(arguments) => commands::up(&arguments.plan(), arguments.start.output.json),
        Command::List { json } => list::list(json),
        Command::Check { scenario, json } => check::check(&scenario, json),
        Command::Planners { json } => algorithms::list(Role::GlobalPlanner, json),
        Command::Controllers { json } => algorithms::list(Role::LocalPlanner, json),
        Command::Params(arguments) => params::params(&arguments),
        Command::Schema => params::schema(),
        Command::Ps { json } => remote::ps(json),
        Command::Why(arguments) => why::why(&arguments),
        Command::Top(arguments) => top::top(&arguments),
        Command::Topics(arguments) => topics::topics(&arguments),
        Command::Logs(arguments) => logs::logs(&arguments),
        Command::Map(arguments) => map_save::map(&arguments),
        Command::Bag(arguments) => bag::bag(&arguments),
        Command::Diff(arguments) => diff::diff(&arguments),
        Command::Replay(arguments) => replay::replay(&arguments),
        Command::Bisect(arguments) => bisect::bisect(&arguments),
        Command::Debug(arguments) => debug::debug(&arguments),
        Command::Import(arguments) => import::import(&arguments),
        Command::View(arguments) => match &arguments.file {
            Some(file) => view_recording::view(file, &arguments),
            None => live_view::view(&arguments),
        },
        Command::Doctor(arguments) => doctor::doctor(&arguments),
        Command::Goal(arguments) => goal::goal(&arguments),
        Command::Goals(arguments) => goal::goals(&arguments),
        Command::Cancel(arguments) => verbs::cancel(&arguments),
        Command::Pause(arguments) => verbs::pause(&arguments),
        Command::Resume(arguments) => verbs::resume(&arguments),
        Command::Step(arguments) => verbs::step(&arguments),
        Command::Speed(arguments) => verbs::speed(&arguments),
        Command::Pose(arguments) => verbs::pose(&arguments),
        Command::Obstacle(arguments) => verbs::obstacle(&arguments),
        Command::Zone(arguments) => zone::zone(&arguments),
        Command::Fault(arguments) => fault::fault(&arguments),
        Command::Swap(arguments) => swap::swap(&arguments),
        Command::Shadow(arguments) => swap::shadow(&arguments),
        Command::Status(arguments) => verbs::status(&arguments),
        Command::Wait(arguments) => verbs::wait(&arguments),
        Command::Down(arguments) => verbs::down(&arguments),
        Command::Link(command) => host::keys::link(&command),
        Command::Contract(arguments) => zeronav_contract_kit::contract(&arguments),
        Command::New(arguments) => new_package::new(&arguments),
        Command::Picture(arguments) => {
            picture::picture(&arguments.run, arguments.out.as_deref(), arguments.animated)
        }
        Command::Draw(arguments) => {
            picture::picture(&arguments.run, arguments.out.as_deref(), true)
        }
        Command::Report(arguments) => report::report(&arguments.runs, arguments.out.as_deref()),
        Command::Suite(arguments) => match arguments.of_recordings() {
            Ok(Some(plan)) => recordings::recordings(&plan),
            Ok(None) => match arguments.of_merge() {
                Ok(Some(shards)) => commands::merge(shards, &arguments.plan(), arguments.json),
                Ok(None) => commands::suite(&arguments.plan(), arguments.json),
                Err(problem) => terminal::usage(&problem),
            },
            Err(problem) => terminal::usage(&problem),
        },
        Command::Completions { shell } => completions::completions(shell),
        Command::Man { folder, force } => completions::man(&folder, force),
        Command::Clean { .. }
        | Command::Busy { .. }
        | Command::WithoutMemory(_)
        | Command::Warden => ExitCode::SUCCESS,
    })
}

/// The command line, or the exit code after what is wrong with it, or help, was said.
fn command_line() -> Result<Cli, ExitCode> {
    if let Some(word) = arguments::unprintable(std::env::args_os().skip(1)) {
        return Err(terminal::usage(&format!(
            "`{word}` holds control characters: rename that file or folder"
        )));
    }
    Cli::try_parse().map_err(|error| {
        // Help for a command line without a command is help, too.
        let help = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
        if error.use_stderr() && !help {
            return terminal::usage(&one_line(&error));
        }
        let _ = error.print();
        ExitCode::from(if help { EXIT_USAGE } else { 0 })
    })
}
