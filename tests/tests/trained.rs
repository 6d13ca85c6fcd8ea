//! The committed model: what it was taught is understood, and what resembles it, but means something
//! else, is refused. `docs/report` has the shares among thousands of such sentences.

include!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../core/examples/observed/mod.rs"
));

use nsrm_core::{Planner, Refusal};
use nsrm_tabletop::TABLETOP;

/// Sentences with the object that each step moves.
const EXECUTED: [(&str, &[u32]); 8] = [
    ("put the red block on the magenta block", &[4]),
    (
        "put the small red block to the left of the magenta block",
        &[4],
    ),
    ("move the green block on the lego block", &[1]),
    (
        "put the red block on the magenta block, then put the yellow block on the red block",
        &[4, 3],
    ),
    ("put the yellow block to the right of the green one", &[3]),
    ("put the red block next to the magenta block", &[4]),
    (
        "put the yellow block in front and to the right of the green one",
        &[3],
    ),
    (
        "put the second block from the left on the rightmost one",
        &[3],
    ),
];

/// Sentences with relations, compounds, extremes, ordinals, several objects, pronouns, values that stand apart, towers
/// and rows, what is taken back, steps in another order, distances, phrases that are read as others, and their programs.
const PARSED: [(&str, &str); 58] = [
    (
        "move the red block so that it is to the left of the blue one",
        "Action(MoveLeft, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "The red block is supposed to be on the blue one. Once that's done, I'd appreciate it if you put green on white.",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(white, Scene())))",
    ),
    (
        "put the red block two centimetres to the left of the blue one",
        "Action(MoveLeft, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())), Distance(0.020))",
    ),
    (
        "put red behind blue, with a gap of 3 cm, and the green one an inch away from it",
        "Action(MoveBehind, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())), Distance(0.030))\n\
         Action(MoveNextTo, Unique(Filter(green, Scene())), Unique(Filter(red, Scene())), Distance(0.025))",
    ),
    (
        "move the red block 5cm away from the blue one, to its right",
        "Action(MoveRight, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())), Distance(0.050))",
    ),
    (
        "put all red blocks 10 mm left of the blue one",
        "Action(MoveLeft, All(Filter(red, Scene())), Unique(Filter(blue, Scene())), Distance(0.010))",
    ),
    (
        "slide the red block 5 cm to the left",
        "Action(MoveLeft, Unique(Filter(red, Scene())), Itself(), Distance(0.050))",
    ),
    (
        "put the red block on the blue one, then move it two inches away from me",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveBehind, Unique(Filter(red, Scene())), Itself(), Distance(0.051))",
    ),
    (
        "put the red block on the blue one, then put it on the white one",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(white, Scene())))",
    ),
    (
        "after you put the red block on the blue one, put it on the green one",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(green, Scene())))",
    ),
    (
        "put everything on the table except the red block",
        "Action(MoveOn, All(Except(Unique(Filter(red, Scene())), Scene())), Table())",
    ),
    (
        "put the small block that is not red on the blue one",
        "Action(MoveOn, Unique(Except(All(Filter(red, Scene())), Filter(small, Scene()))), \
         Unique(Filter(blue, Scene())))",
    ),
    (
        "put the two red blocks on the big red lego",
        "Action(MoveOn, Both(Filter(red, Scene())), Unique(Filter(lego, Filter(red, Scene()))))",
    ),
    (
        "put the big red block on the large blue one",
        "Action(MoveOn, Unique(Filter(lego, Filter(red, Scene()))), \
         Unique(Filter(lego, Filter(blue, Scene()))))",
    ),
    (
        "remove the red block from the blue one",
        "Action(MoveOn, Unique(Filter(red, Relate(MoveOn, Unique(Filter(blue, Scene()))))), Table())",
    ),
    (
        "move the red block from the blue one to the left of the white one",
        "Action(MoveLeft, Unique(Filter(red, Relate(MoveOn, Unique(Filter(blue, Scene()))))), \
         Unique(Filter(white, Scene())))",
    ),
    (
        "put the red block, no, the green one, on the blue block",
        "Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "put the red block on the blue one, sorry, on the white one",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(white, Scene())))",
    ),
    (
        "put the red block instead of the green one on the blue block",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "before you put the red block on the blue one, put the green block on the white one",
        "Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(white, Scene())))\n\
         Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "put the red block on the blue one after putting the green block on the white one",
        "Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(white, Scene())))\n\
         Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "put the small red block on the block left of the magenta block",
        "Action(MoveOn, Unique(Filter(small, Filter(red, Scene()))), \
         Unique(Relate(MoveLeft, Unique(Filter(magenta, Scene())))))",
    ),
    (
        "put the small red block on the block to the left of the magenta block",
        "Action(MoveOn, Unique(Filter(small, Filter(red, Scene()))), \
         Unique(Relate(MoveLeft, Unique(Filter(magenta, Scene())))))",
    ),
    (
        "move the red block on the cube on the left of the yellow block",
        "Action(MoveOn, Unique(Filter(red, Scene())), \
         Unique(Relate(MoveLeft, Unique(Filter(yellow, Scene())))))",
    ),
    (
        "put the block left of the magenta block on the red block",
        "Action(MoveOn, Unique(Relate(MoveLeft, Unique(Filter(magenta, Scene())))), \
         Unique(Filter(red, Scene())))",
    ),
    (
        "move the block to the right of the red one on the magenta block",
        "Action(MoveOn, Unique(Relate(MoveRight, Unique(Filter(red, Scene())))), \
         Unique(Filter(magenta, Scene())))",
    ),
    (
        "put the block nearest to the white cube on the red block",
        "Action(MoveOn, Unique(Relate(Nearest, Unique(Filter(white, Scene())))), \
         Unique(Filter(red, Scene())))",
    ),
    (
        "put the red one closest to the blue block left of the green one",
        "Action(MoveLeft, Unique(Filter(red, Relate(Nearest, Unique(Filter(blue, Scene()))))), \
         Unique(Filter(green, Scene())))",
    ),
    (
        "put the block furthest from the yellow one on the green one",
        "Action(MoveOn, Unique(Relate(Farthest, Unique(Filter(yellow, Scene())))), \
         Unique(Filter(green, Scene())))",
    ),
    (
        "put the red block next to the blue one",
        "Action(MoveNextTo, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "move the cube right beside the yellow one onto the red one, please",
        "Action(MoveOn, Unique(Relate(MoveNextTo, Unique(Filter(yellow, Scene())))), \
         Unique(Filter(red, Scene())))",
    ),
    (
        "put the red block next to the blue one, on its left",
        "Action(MoveLeft, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "Take the red block and put it in front and to the left of the blue one.",
        "Action(MoveFrontLeft, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "put the red one on the blue one, then the green one diagonally to the back right of the red one",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveBehindRight, Unique(Filter(green, Scene())), Unique(Filter(red, Scene())))",
    ),
    (
        "put the leftmost red block on the biggest one",
        "Action(MoveOn, Unique(Extreme(MoveLeft, Filter(red, Scene()))), \
         Unique(Extreme(Largest, Scene())))",
    ),
    (
        "place the topmost cube to the right of the red block nearest to the rearmost one",
        "Action(MoveRight, Unique(Extreme(MoveOn, Scene())), \
         Unique(Filter(red, Relate(Nearest, Unique(Extreme(MoveBehind, Scene()))))))",
    ),
    (
        "stack all the red blocks on the blue one",
        "Action(MoveOn, All(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "put both small blocks left of the white one",
        "Action(MoveLeft, Both(Filter(small, Scene())), Unique(Filter(white, Scene())))",
    ),
    (
        "put both the red block and the green one on the blue block",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(red, Scene())))",
    ),
    (
        "take the red and green blocks and put them both left of the white one",
        "Action(MoveLeft, Unique(Filter(red, Scene())), Unique(Filter(white, Scene())))\n\
         Action(MoveLeft, Unique(Filter(green, Scene())), Unique(Filter(red, Scene())))",
    ),
    (
        "put the red blocks on the blue one",
        "Action(MoveOn, All(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "um, so first, could you please put the red block on the, uh, blue one, if you can",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "pick up the red block and place on the blue one",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "lift the red block onto the blue one",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "take all of the red cubes and put them on the blue one",
        "Action(MoveOn, All(Filter(red, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "put the small block that is red on the lego one that's blue",
        "Action(MoveOn, Unique(Filter(small, Filter(red, Scene()))), \
         Unique(Filter(lego, Filter(blue, Scene()))))",
    ),
    (
        "put the small and red block left of the green one",
        "Action(MoveLeft, Unique(Filter(small, Filter(red, Scene()))), Unique(Filter(green, Scene())))",
    ),
    (
        "put the block whose colour is blue and that is small on the red one",
        "Action(MoveOn, Unique(Filter(blue, Filter(small, Scene()))), Unique(Filter(red, Scene())))",
    ),
    (
        "build a tower of the red block, the green one and the small blue one",
        "Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(red, Scene())))\n\
         Action(MoveOn, Unique(Filter(small, Filter(blue, Scene()))), Unique(Filter(green, Scene())))",
    ),
    (
        "Stack the red, green and blue blocks from top to bottom, please.",
        "Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(green, Scene())))",
    ),
    (
        "could you put the red block and the blue one next to each other, then put the white one on it",
        "Action(MoveRight, Unique(Filter(blue, Scene())), Unique(Filter(red, Scene())))\n\
         Action(MoveOn, Unique(Filter(white, Scene())), Unique(Filter(blue, Scene())))",
    ),
    (
        "take the block left of the white one and the small red block and line them up from front to back",
        "Action(MoveBehind, Unique(Filter(small, Filter(red, Scene()))), \
         Unique(Relate(MoveLeft, Unique(Filter(white, Scene())))))",
    ),
    (
        "put the red block on the blue one and the green one on it",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveOn, Unique(Filter(green, Scene())), Unique(Filter(red, Scene())))",
    ),
    (
        "put the 2nd red block from the left on the third biggest one",
        "Action(MoveOn, Unique(Extreme(MoveLeft, 2, Filter(red, Scene()))), \
         Unique(Extreme(Largest, 3, Scene())))",
    ),
    (
        "put the block that is second from the top to the right of the blue one on the far left",
        "Action(MoveRight, Unique(Extreme(MoveOn, 2, Scene())), \
         Unique(Extreme(MoveLeft, Filter(blue, Scene()))))",
    ),
    (
        "take the second leftmost block and put it on the white one",
        "Action(MoveOn, Unique(Extreme(MoveLeft, 2, Scene())), Unique(Filter(white, Scene())))",
    ),
    (
        "take the red block and put it on the blue one, then put it behind the white one",
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))\n\
         Action(MoveBehind, Unique(Filter(red, Scene())), Unique(Filter(white, Scene())))",
    ),
    (
        "put the small red one on the blue one. then put the green one to its left",
        "Action(MoveOn, Unique(Filter(small, Filter(red, Scene()))), Unique(Filter(blue, Scene())))\n\
         Action(MoveLeft, Unique(Filter(green, Scene())), Unique(Filter(small, Filter(red, Scene()))))",
    ),
];

/// What resembles a tower or a row, a number or an exception; elsewhere its words are unknown.
const NOT_UNDERSTOOD: [&str; 14] = [
    // Numbers, and what leaves nothing out.
    "move the red block two blocks to the left",
    "put all small blocks, not red, on the table",
    "put the small block not red on the blue one",
    "put all the blocks except the red one and the blue one on the table",
    "put two red blocks on the blue one",
    "build a tower of the red block",
    "build a tower of the red or the green block",
    "build a tower of red and not green",
    "build a tower of red and green on the blue block",
    "build a tower of red and green, on the blue block",
    "line up red and green left of the blue one",
    "build a tower of red and green from left to right",
    "don't stack the red and the green block",
    "put the red block on the tower",
];

/// All of known words.
const REFUSED: [&str; 41] = [
    "move the red block 5 cm up",
    "move the red block to the left",
    // In which order?
    "put the red block on the blue one, then put the green one on the white one after you put the cyan one on it",
    "before you put the red block on the blue one, put it on the green one",
    "once you have put the red block on the blue one",
    // Where to?
    "take the red block from the blue one",
    // Two relations at once.
    "put the red block above and to the left of the magenta block",
    "put the red block to the top left of the magenta block",
    // Next to what, or on which side?
    "put the red block next to",
    "put the red block next to the blue one and the green one",
    "put the red block next to the blue one, on its left and its right",
    "put the red block next to the red, blue block, on its left",
    // Nearest to what? And no places.
    "put the nearest red block on the magenta block",
    "put the red block on the closest green block",
    "put the red block nearest to the magenta block",
    "put the red block away from the magenta block",
    // Counted from where, and to where?
    "put the first red block on the magenta block",
    "put the second red block on the magenta block from the left",
    "put the second red block from the left of the blue one on the magenta block",
    "put the second and the third block from the left on the magenta block",
    "put the red block second from the left",
    "put the second biggest block from the left on the magenta block",
    // Another order of time.
    "put the red block on the magenta block, first put the yellow block on the green block",
    // Two values of one attribute.
    "put the red yellow block on the magenta block",
    "put the red block on the magenta green block",
    "put the small lego block on the red block",
    "put the leftmost topmost block on the red block",
    // Extremes as places, and two objects.
    "move the red block leftmost",
    "put the red block leftmost of the magenta block",
    "put the leftmost and the rightmost block on the red one",
    // Several objects where one is needed, or as one.
    "put the red block on all blue blocks",
    "put all the leftmost blocks on the red one",
    "put all blocks nearest to the red one on the blue one",
    // Two values of one type, or of two objects.
    "put the red block that is green on the blue one",
    "put the small and red block and green on the blue one",
    "put the red and green block on the blue one",
    // Two objects, and not one on the other.
    "the red block and the green block on the blue one",
    "put all red blocks on the blue one and then put the green one on it",
    // What nothing stands for, or what does not lie there any more, or two ways to read it.
    "put it on the red block",
    "put the red block on the green one, then put it on it",
    "put the leftmost block on the white one, then put it on the green one",
];

#[test]
fn what_is_meant_is_planned_and_what_is_meant_otherwise_refused() {
    let scene = scene(&TABLETOP);
    let planner = Planner::new(&TABLETOP);
    for (sentence, expected) in EXECUTED {
        let plan = planner.plan(&scene, sentence);
        let plan = plan.unwrap_or_else(|refusal| panic!("{sentence}: {refusal}"));
        let moved: Vec<u32> = plan.sub_goals().map(|goal| goal.object).collect();
        assert_eq!(moved, expected, "{sentence}");
    }
    for (sentence, expected) in PARSED {
        let parsed = planner.parse(sentence);
        let parsed = parsed.unwrap_or_else(|refusal| panic!("{sentence}: {refusal}"));
        let program = parsed.program().notation(&TABLETOP).to_string();
        assert_eq!(program, expected, "{sentence}");
    }
    for sentence in NOT_UNDERSTOOD {
        if let Ok(parsed) = planner.parse(sentence) {
            panic!("{sentence}: {}", parsed.program().notation(&TABLETOP));
        }
    }
    for (sentence, message) in [
        (
            "Build a tower of the red block",
            "\"Build\" is only understood around a list of objects, as in \"build a line from …\"; \
             list each object by itself, and nothing else",
        ),
        (
            "put the red block at the bottom",
            "\"bottom\" is only understood around a list of objects, as in \"build a pile from … \
             from bottom to top\"; list",
        ),
        (
            "don't put the red block on the blue one, but not on the green one",
            "\"don't\" is not a word that the model knows; use another one",
        ),
        (
            "do not put the red block on the blue one",
            "\"not\" is only understood between two descriptions, as in \"the … not the …\", with the \
             same words before both; say only what you mean",
        ),
        (
            "put the 4cm block on the blue one",
            "\"4cm\" is only understood in a distance from another object, as in \"2 cm to the left of the …\"; \
             say only how far apart the two should be",
        ),
        (
            "put the red block between the blue one",
            "\"between\" is only understood with two objects behind it, as in \"between the … and the …\"; name both",
        ),
        (
            "put the red block in the middle",
            "\"middle\" is only understood with two objects behind it",
        ),
        (
            "put the two centimetres red block left of the blue one",
            "\"two\" is only understood in a distance from another object",
        ),
        (
            "After you put the red block on the blue one, stop",
            "\"After you\" leaves open in which order the steps are carried out",
        ),
    ] {
        let refusal = planner.parse(sentence).unwrap_err();
        let told = refusal.in_context(&TABLETOP, sentence).to_string();
        assert!(told.starts_with(message), "{told}");
        assert_eq!(refusal.suggestion(&TABLETOP, sentence), None);
    }
    for sentence in REFUSED {
        // By the parser, whatever the scene, and not for a word alone.
        match planner.parse(sentence) {
            Ok(parsed) => panic!("{sentence}: {}", parsed.program().notation(&TABLETOP)),
            Err(Refusal::UnknownWord { .. }) => panic!("{sentence}: a word is unknown"),
            Err(_) => {}
        }
    }
}
