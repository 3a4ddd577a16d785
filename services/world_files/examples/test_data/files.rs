//! The files of `tests/data`, drawn from fixed seeds.

use core::fmt::Write as _;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::error::Error;
use zeronav_msgs::Cell;
use zeronav_robot_description::RobotPreset;
use zeronav_world::generate::generate;
use zeronav_world::spec::{Family, GeneratedSpec};
use zeronav_world::{Occupancy, StaticMap};
use zeronav_world_files::synthetic::{Robot, clutter, crowd, orbits};

/// Every file by its path below the folder.
pub(crate) fn all() -> Result<BTreeMap<String, Vec<u8>>, Box<dyn Error>> {
    let mut files = BTreeMap::new();
    let footprint = RobotPreset::Jackal.robot().footprint()?;
    let robot = Robot {
        radius_m: footprint.circumscribed_radius_m(),
    };
    barn(robot, &mut files)?;
    dynabarn(robot, &mut files)?;
    pedestrians(&mut files)?;
    rosmaps(&mut files)?;
    movingai(&mut files)?;
    Ok(files)
}

type Files = BTreeMap<String, Vec<u8>>;

/// Six worlds from sparse to dense.
fn barn(robot: Robot, files: &mut Files) -> Result<(), Box<dyn Error>> {
    let mut index = String::from("world,n_cylinders,path_length_m,ot_s\n");
    for (number, fill_ratio) in (0_u32..).zip([0.12, 0.15, 0.18, 0.20, 0.22, 0.24]) {
        let rule = clutter::Rule {
            fill_ratio,
            smoothings: 3,
        };
        let drawn = clutter::draw(rule, robot, u64::from(number) + 100)?;
        let mut text = String::from("x_m,y_m,r_m\n");
        for [x, y, r] in &drawn.world.cylinders {
            writeln!(text, "{x},{y},{r}")?;
        }
        let (n, length_m) = (drawn.world.cylinders.len(), drawn.path_length_m);
        writeln!(index, "{number},{n},{length_m:.4},{:.4}", length_m / 2.0)?;
        files.insert(format!("barn/worlds/world_{number:03}.csv"), text.into());
    }
    files.insert("barn/index.csv".to_owned(), index.into());
    Ok(())
}

/// A world of each difficulty.
fn dynabarn(robot: Robot, files: &mut Files) -> Result<(), Box<dyn Error>> {
    let mut index = String::from("world,difficulty,n_obstacles\n");
    let sorts = [
        ("easy", 4, 0.5..0.8),
        ("medium", 6, 0.6..1.0),
        ("hard", 8, 0.8..1.3),
    ];
    for (number, (difficulty, n, speed_mps)) in (0_u32..).zip(sorts) {
        let rule = orbits::Rule { n, speed_mps };
        let world = orbits::arena(&rule, robot, u64::from(number) + 200)?;
        let mut text = String::from("obstacle,plugin,period_s,t_s,x_m,y_m\n");
        for (obstacle, round) in world.rounds.iter().enumerate() {
            let period_s = round.last().map_or(0.0, |row| row[0]);
            for [t, x, y] in round {
                writeln!(text, "{obstacle},bend,{period_s},{t},{x},{y}")?;
            }
        }
        writeln!(index, "{number},{difficulty},{n}")?;
        files.insert(format!("dynabarn/world_{number:02}.csv"), text.into());
    }
    files.insert("dynabarn/index.csv".to_owned(), index.into());
    Ok(())
}

/// Two minutes of seven people in a room.
fn pedestrians(files: &mut Files) -> Result<(), Box<dyn Error>> {
    let rule = crowd::Rule {
        n: 7,
        room_m: [[0.0, 0.0], [14.0, 9.0]],
        lasts_s: 120.0,
    };
    let scene = crowd::record(&rule, 300)?;
    let mut rows: Vec<(f64, u64, [f64; 2])> = Vec::new();
    for (id, samples) in &scene.walkers {
        rows.extend(samples.iter().map(|[t, x, y]| (*t, *id, [*x, *y])));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut text = String::from("t_s,id,x_m,y_m\n");
    for (t, id, [x, y]) in rows {
        writeln!(text, "{t},{id},{x},{y}")?;
    }
    files.insert("pedestrians/hall.csv".to_owned(), text.into());
    Ok(())
}

/// Columns and rows of the drawn map; a pixel is 0.1 m.
const MAP: [usize; 2] = [120, 80];

/// Six rooms along a corridor, with pillars; grey 205 outside of the house, and a strip of a grey
/// that is neither free nor occupied.
fn pixel(x: usize, y: usize) -> u8 {
    const WALL: u8 = 0;
    const FREE: u8 = 254;
    const UNKNOWN: u8 = 205;
    if !(5..115).contains(&x) || !(4..76).contains(&y) {
        return UNKNOWN;
    }
    let outer = !(7..113).contains(&x) || !(6..74).contains(&y);
    // Along the corridor, with a door of 1.4 m into each room.
    let door = [22..36, 53..67, 84..98]
        .iter()
        .any(|door| door.contains(&x));
    let along = ((32..34).contains(&y) || (46..48).contains(&y)) && !door;
    let between = ((42..44).contains(&x) || (76..78).contains(&x)) && !(34..46).contains(&y);
    if outer || along || between {
        return WALL;
    }
    let pillars = [(14, 14), (32, 60), (52, 22), (66, 58), (88, 64), (104, 16)];
    let in_pillar = |(px, py): &(usize, usize)| px.abs_diff(x).pow(2) + py.abs_diff(y).pow(2) <= 6;
    if pillars.iter().any(in_pillar) {
        return WALL;
    }
    if x == 112 && y > 60 { 140 } else { FREE }
}

/// One picture as P2, P5 and PNG, and as a PNG of its negative.
fn rosmaps(files: &mut Files) -> Result<(), Box<dyn Error>> {
    let [width, height] = MAP;
    // The first row of an image is the uppermost.
    let pixels: Vec<u8> = (0..height)
        .rev()
        .flat_map(|y| (0..width).map(move |x| pixel(x, y)))
        .collect();
    let negative: Vec<u8> = pixels.iter().map(|pixel| 255 - pixel).collect();
    let mut binary = format!("P5\n# drawn\n{width} {height}\n255\n").into_bytes();
    binary.extend(&pixels);
    let mut ascii = format!("P2\n{width} {height}\n255\n");
    for row in pixels.chunks(width) {
        let words: Vec<String> = row.iter().map(u8::to_string).collect();
        writeln!(ascii, "{}", words.join(" "))?;
    }
    let png = |pixels: &[u8]| -> Result<Vec<u8>, Box<dyn Error>> {
        let mut bytes = Vec::new();
        let (width, height) = (u32::try_from(width)?, u32::try_from(height)?);
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.write_header()?.write_image_data(pixels)?;
        Ok(bytes)
    };
    let images = [
        ("rooms_p5.pgm", 0, binary),
        ("rooms_p2.pgm", 0, ascii.into_bytes()),
        ("rooms_png.png", 0, png(&pixels)?),
        ("rooms_negative.png", 1, png(&negative)?),
    ];
    for (image, negate, bytes) in images {
        let stem = image.split('.').next().unwrap_or(image);
        let yaml = format!(
            "image: {image}\nresolution: 0.1\norigin: [-0.5, -0.4, 0.0]\nnegate: {negate}\n\
             occupied_thresh: 0.65\nfree_thresh: 0.196\n"
        );
        files.insert(format!("rosmaps/{stem}.yaml"), yaml.into());
        files.insert(format!("rosmaps/{image}"), bytes);
    }
    Ok(())
}

/// Three maps with questions; the lengths come from the plain search of Dijkstra below.
fn movingai(files: &mut Files) -> Result<(), Box<dyn Error>> {
    let sorts = [
        ("cells", Family::Iid, 0.25),
        ("traps", Family::Concave { side_cells_max: 10 }, 0.2),
        ("corridors", Family::Corridor { width_cells: 3 }, 0.0),
    ];
    for (seed, (name, family, ratio)) in (400..).zip(sorts) {
        let drawn = generate(&GeneratedSpec {
            family,
            size_cells: [64, 48],
            ratio,
            start_cell: None,
            goal_cell: None,
            seed,
            resolution_m: 1.0,
        })?;
        let (width, height) = drawn.map.geometry.size();
        let mut text = format!("type octile\nheight {height}\nwidth {width}\nmap\n");
        for y in 0..height {
            text.extend((0..width).map(|x| {
                let cell = Cell::new(x, y);
                // Both letters of either kind stand somewhere.
                match (is_free(&drawn.map, cell), (x + y) % 7) {
                    (true, 0) => 'G',
                    (true, _) => '.',
                    (false, 0) => 'T',
                    (false, _) => '@',
                }
            }));
            text.push('\n');
        }
        files.insert(format!("movingai/{name}.map"), text.into());
        let questions = questions(&drawn.map, name, drawn.start)?;
        files.insert(format!("movingai/{name}.map.scen"), questions.into());
    }
    Ok(())
}

/// Questions between cells that are spread over the map, the nearest first.
fn questions(map: &StaticMap, name: &str, from: Cell) -> Result<String, Box<dyn Error>> {
    const STARTS: usize = 8;
    const GOALS: usize = 5;
    let reached: Vec<Cell> = lengths(map, from)
        .into_keys()
        .map(|(y, x)| Cell::new(x, y))
        .collect();
    let (width, height) = map.geometry.size();
    let mut asked = Vec::new();
    for n in 0..STARTS {
        let start = reached[n * reached.len() / STARTS];
        let lengths = lengths(map, start);
        for m in 0..GOALS {
            let goal = reached[(n * 37 + m * reached.len() / GOALS + 11) % reached.len()];
            let length = lengths
                .get(&(goal.y, goal.x))
                .ok_or("a goal was not reached")?;
            asked.push((*length, start, goal));
        }
    }
    asked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut text = String::from("version 1\n");
    for (length, start, goal) in asked {
        let bucket = (length / 4.0).floor();
        writeln!(
            text,
            "{bucket}\t{name}.map\t{width}\t{height}\t{}\t{}\t{}\t{}\t{length:.8}",
            start.x, start.y, goal.x, goal.y
        )?;
    }
    Ok(text)
}

fn is_free(map: &StaticMap, cell: Cell) -> bool {
    map.get(cell) == Some(Occupancy::Free)
}

/// Length of the shortest way from a cell to every other that is reached, by row and column.
/// Dijkstra, "A note on two problems in connexion with graphs", 1959. A diagonal step costs sqrt 2
/// and needs both cells beside it free.
fn lengths(map: &StaticMap, from: Cell) -> BTreeMap<(i32, i32), f64> {
    let mut known = BTreeMap::new();
    // As straight and diagonal steps, compared by their length: the sum has one rounding only.
    let length = |(straight, diagonal): (u32, u32)| {
        f64::from(straight) + f64::from(diagonal) * core::f64::consts::SQRT_2
    };
    let key = |steps: (u32, u32)| Reverse((length(steps).to_bits(), steps));
    let mut open = BinaryHeap::from([(key((0, 0)), (from.y, from.x))]);
    while let Some((Reverse((_, steps)), (y, x))) = open.pop() {
        if known.contains_key(&(y, x)) {
            continue;
        }
        known.insert((y, x), length(steps));
        for (dx, dy) in [
            (1, 0),
            (0, 1),
            (-1, 0),
            (0, -1),
            (1, 1),
            (-1, 1),
            (-1, -1),
            (1, -1),
        ] {
            let free = |dx: i32, dy: i32| is_free(map, Cell::new(x + dx, y + dy));
            let (straight, diagonal) = steps;
            if dx == 0 || dy == 0 {
                if free(dx, dy) {
                    open.push((key((straight + 1, diagonal)), (y + dy, x + dx)));
                }
            } else if free(dx, dy) && free(dx, 0) && free(0, dy) {
                open.push((key((straight, diagonal + 1)), (y + dy, x + dx)));
            }
        }
    }
    known
}
