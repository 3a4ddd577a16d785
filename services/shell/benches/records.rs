//! What an answer costs that is measured: its record on `run/spans`, with the reader that launch
//! has, and its readings of the monotonic clock. The two readings of the processor time are not in it.
//!
//! `cargo bench -p zeronav-shell`

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use zeronav_msgs::role::Role;
use zeronav_msgs::span::{Span, SpanKind};
use zeronav_msgs::stages::{Stage, StageTimer};
use zeronav_shell::clock::now_ns;
use zeronav_shell::{Domain, Peer};

/// Readings of the monotonic clock in an answer: woken, started, published, end of the cycle.
const READINGS: usize = 4;

fn records(criterion: &mut Criterion) {
    let domain = Domain::create().expect("a domain");
    let root = domain.root().to_owned();
    let launch = Peer::join(domain, Role::Launch, 1).expect("launch joins");
    let topics = launch.create_topics().expect("topics");
    let mut reader = launch.span_reader().expect("a reader");
    let service = Domain::join(&root).expect("the domain");
    let service = Peer::join(service, Role::Mapping, 1).expect("a peer");
    let mut writer = service.span_writer().expect("a writer");
    let span = Span {
        role: Role::Mapping.code(),
        kind: SpanKind::Answer.code(),
        epoch: 1,
        ..Span::default()
    };
    let mut n = 0_u64;
    criterion.bench_function("a record on run/spans", |bencher| {
        bencher.iter(|| {
            n += 1;
            let mut record = span;
            record.tick = n;
            writer.write(black_box(record));
        });
    });
    assert_eq!(writer.failed(), 0, "a full queue drops its oldest record");
    criterion.bench_function("clock readings of an answer", |bencher| {
        bencher.iter(|| {
            for _ in 0..READINGS {
                black_box(now_ns());
            }
        });
    });
    for (name, mut timer) in [
        (
            "stages of an answer, timed",
            StageTimer::new(now_ns, now_ns()),
        ),
        ("stages of an answer, off", StageTimer::default()),
    ] {
        criterion.bench_function(name, |bencher| {
            bencher.iter(|| {
                for stage in Stage::of(Role::Mapping) {
                    black_box(&mut timer).mark(black_box(*stage));
                }
            });
        });
    }
    reader.drain(|span| {
        black_box(span);
    });
    drop((reader, writer));
    let _ = service.leave();
    drop(topics);
    launch.leave().close().expect("the domain is removed");
}

criterion_group!(benches, records);
criterion_main!(benches);
