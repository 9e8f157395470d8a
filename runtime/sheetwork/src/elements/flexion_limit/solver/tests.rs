use super::*;

/// A chain of five nodes along x in the plane z = 0, bent by `bend` (rad) at each inner node.
fn chain(bend: f64) -> (FlexionLimit, Vectors) {
    let mut x = Vectors::default();
    let mut place = DVec3::ZERO;
    for i in 0..5 {
        x.push(place);
        let angle = -bend * f64::from(i);
        place += DVec3::new(angle.cos(), angle.sin(), 0.0);
    }
    (FlexionLimit { triples: vec![[0, 1, 2], [1, 2, 3], [2, 3, 4]], limit: 20.0 }, x)
}

fn workspace(nodes: usize) -> FlexionWorkspace {
    let mut work = FlexionWorkspace { mobility: vec![DVec3::ONE; nodes], ..FlexionWorkspace::default() };
    work.reserve(nodes, nodes, 0);
    work
}

#[test]
fn nodes_thrown_beyond_the_limit_end_at_it_with_the_same_momentum() {
    let (limit, start) = chain(0.2);
    let (mut x, mut v) = (start.clone(), Vectors::zeros(5));
    // The ends fall and the middle rises, by more than the limit in one step.
    let dt = 0.1;
    for (i, up) in [-2.0, 0.0, 3.0, 0.0, -2.0].into_iter().enumerate() {
        v.set(i, DVec3::new(0.0, up, 0.3));
    }
    x.add_scaled(dt, &v);
    let (free, momentum) = ((x.clone(), v.clone()), v.iter().sum::<DVec3>());
    assert!(limit.largest_angle(&x) > 40.0, "{}", limit.largest_angle(&x));
    let step = LimitedStep { start: &start, free: (&free.0, &free.1), dt, drift: 1.0 };
    let mut impulses = LimitImpulses::default();
    impulses.reset(3, 0);
    workspace(5).solve((&limit, None), &step, (&mut x, &mut v), &mut impulses);
    assert!(limit.largest_angle(&x) < 20.5, "{}", limit.largest_angle(&x));
    assert!(v.iter().sum::<DVec3>().distance(momentum) < 1e-12);
    // The end of the next step is within the limit too.
    x.add_scaled(dt, &v);
    assert!(limit.largest_angle(&x) < 22.0, "{}", limit.largest_angle(&x));
}

/// The middle of three nodes lies on a point, at the limit. The outer ones, guided along y, hang
/// from it by the limit alone, and the contact carries the weight of all.
#[test]
fn a_bent_sheet_on_an_edge_rests_where_it_is() {
    let half = 10.0_f64.to_radians();
    let mut start = Vectors::default();
    for side in [-1.0, 0.0, 1.0] {
        start.push(DVec3::new(side * half.cos(), -f64::abs(side) * half.sin(), 0.0));
    }
    let limit = FlexionLimit { triples: vec![[0, 1, 2]], limit: 20.0 };
    let (dt, gravity) = (0.01, DVec3::new(0.0, -10.0, 0.0));
    let mut work = workspace(3);
    (work.mobility[0], work.mobility[2]) = (DVec3::Y, DVec3::Y);
    work.contacts.push(LimitContact { friction: 0.3, ..LimitContact::of_node(1, DVec3::Y, 0.0) });
    let mut impulses = LimitImpulses::default();
    impulses.reset(1, 0);
    let (mut x, mut v) = (start.clone(), Vectors::zeros(3));
    for _ in 0..100 {
        let begin = x.clone();
        let mut free = (x.clone(), v.clone());
        for i in 0..3 {
            free.0.add(i, v.get(i) * dt + gravity * (0.5 * dt * dt));
            free.1.add(i, gravity * dt);
        }
        let step = LimitedStep { start: &begin, free: (&free.0, &free.1), dt, drift: 0.5 };
        work.solve((&limit, None), &step, (&mut x, &mut v), &mut impulses);
    }
    // In free fall they would be 5 m lower.
    let moved = (0..3).map(|i| x.get(i).distance(start.get(i))).fold(0.0, f64::max);
    assert!(moved < 0.01, "{moved}: {x:?}");
    assert!((limit.largest_angle(&x) - 20.0).abs() < 0.5, "{}", limit.largest_angle(&x));
    let carried = work.contacts[0].impulse.0 / (3.0 * 10.0 * dt);
    assert!((carried - 1.0).abs() < 0.05, "{carried} of the weight");
}

#[test]
fn a_contact_within_its_friction_bound_does_not_slip() {
    let mut y = [DVec3::new(0.2, -1.0, 0.0)];
    let mut contact = LimitContact { friction: 0.3, ..LimitContact::of_node(0, DVec3::Y, 0.0) };
    let row = ContactRow { target: 0.0, drift: DVec3::ZERO, compliance: (1.0, 1.0) };
    relax_contact(&mut contact, &row, &mut y, &[DVec3::ONE]);
    assert!(y[0].length() < 1e-15, "{y:?}");
    y[0] = DVec3::new(2.0, -1.0, 0.0);
    contact.impulse = (0.0, DVec3::ZERO);
    relax_contact(&mut contact, &row, &mut y, &[DVec3::ONE]);
    assert!(y[0].distance(DVec3::new(1.7, 0.0, 0.0)) < 1e-15, "{y:?}");
}
