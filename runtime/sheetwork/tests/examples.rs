//! Every example of the library runs to its end. Examples check what they show by assertions.

#[path = "../examples/bodies.rs"]
mod bodies;
#[path = "../examples/change_parameters.rs"]
mod change_parameters;
#[path = "../examples/events_and_errors.rs"]
mod events_and_errors;
#[path = "../examples/forces_and_picking.rs"]
mod forces_and_picking;
#[path = "../examples/headless_sweep.rs"]
mod headless_sweep;
#[path = "../examples/heat.rs"]
mod heat;
#[path = "../examples/hello_sheet.rs"]
mod hello_sheet;
#[path = "../examples/rollback.rs"]
mod rollback;

#[test]
fn every_example_runs_to_its_end() {
    for (name, example) in [
        ("bodies", bodies::main as fn() -> Result<(), sheetwork::InputError>),
        ("change_parameters", change_parameters::main),
        ("events_and_errors", events_and_errors::main),
        ("forces_and_picking", forces_and_picking::main),
        ("headless_sweep", headless_sweep::main),
        ("heat", heat::main),
        ("hello_sheet", hello_sheet::main),
        ("rollback", rollback::main),
    ] {
        println!("== {name}");
        example().unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}
