//! The configuration of a newcomer.

use toml::Table;
use zeronav_msgs::role::Role;
use zeronav_scenario::assignment::lay_over;

/// What launch itself tells mapping: it does not depend on the binary.
pub(crate) const GIVEN: [&str; 3] = ["static_map", "area_m", "resolution_m"];

/// The configuration of a newcomer: `keys` over those of the process in the seat, or over none but
/// what launch itself says when it is another program.
#[must_use]
pub(crate) fn merged(incumbent: Table, role: Role, is_same: bool, keys: Table) -> Table {
    let mut table = incumbent;
    if !is_same {
        table.retain(|key, _| role == Role::Mapping && GIVEN.contains(&key));
    }
    lay_over(&mut table, keys);
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use zeronav_scenario::assignment::assignment;

    #[test]
    fn keys_lie_over_those_of_the_same_program_and_over_no_others() {
        let incumbent = "planner = 'a'\nstatic_map = 'm.yaml'\n[x]\none = 1\ntwo = 2";
        let incumbent: Table = toml::from_str(incumbent).expect("TOML");
        let keys = assignment("x.one=3").expect("an assignment");
        let same = merged(incumbent.clone(), Role::Mapping, true, keys.clone());
        assert_eq!(same["x"]["one"].as_integer(), Some(3));
        assert_eq!(same["x"]["two"].as_integer(), Some(2));
        let other = merged(incumbent.clone(), Role::Mapping, false, keys.clone());
        assert_eq!(other.keys().collect::<Vec<_>>(), ["static_map", "x"]);
        assert!(merged(incumbent, Role::GlobalPlanner, false, Table::new()).is_empty());
    }
}
