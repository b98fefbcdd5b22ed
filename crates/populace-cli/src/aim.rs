//! The --look-at and --reach arguments of `populace pose`.

use std::str::FromStr;

use populace::{
    CharacterId, ConstraintFault, Crowd, Error, MemberId, Reach, TablesError, Target, Weight,
};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::mix::name_and_rest;
use crate::names;
use crate::report::as_typed;

/// A point in model space, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point(pub(crate) [f32; 3]);

/// The end joint of a limb, and the point that it reaches for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReachArg {
    pub(crate) joint: String,
    pub(crate) point: Point,
}

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split(',').map(|n| n.trim().parse::<f32>().ok().filter(|n| n.is_finite()));
        let numbers: Option<Vec<f32>> = numbers.collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => Ok(Self([x, y, z])),
            _ => Err(format!(
                "\"{text}\" is not a point; write X,Y,Z in metres, for example 0.3,1.2,0.5"
            )),
        }
    }
}

impl FromStr for ReachArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (joint, rest) = name_and_rest(text)?;
        let point = rest.ok_or("write JOINT=X,Y,Z, for example hand_l=0.3,1.2,0.5")?.parse()?;
        if joint.is_empty() {
            Err("the joint's name is empty".into())
        } else {
            Ok(Self { joint, point })
        }
    }
}

impl Point {
    fn as_json(self) -> Value {
        json!(self.0.map(as_typed))
    }
}

/// Sets a member's look-at and reach targets at full weight, and describes them as JSON.
pub(crate) fn apply(
    crowd: &mut Crowd,
    (character, member): (CharacterId, MemberId),
    look: Option<Point>,
    reaches: &[ReachArg],
) -> Result<[Value; 2], Failure> {
    let at_once = Weight::FULL.over_secs(0.0);
    if let Some(Point(point)) = look {
        crowd
            .member_mut(member)
            .and_then(|mut m| m.look_at(Target::InModel(point), at_once))
            .map_err(refused)?;
    }
    let skeleton = crowd.character(character)?.asset().skeleton.clone();
    let mut described = Vec::new();
    for ReachArg { joint, point } in reaches {
        let end = names::joint(&skeleton, joint)?;
        crowd
            .member_mut(member)
            .and_then(|mut m| m.reach(Reach::with(end), Target::InModel(point.0), at_once))
            .map_err(refused)?;
        described.push(json!({"joint": joint, "target": point.as_json()}));
    }
    Ok([look.map_or(Value::Null, Point::as_json), Value::Array(described)])
}

/// Reports a target that this file's skeleton cannot have as wrong usage.
fn refused(error: Error) -> Failure {
    let Error::Tables(TablesError::BadConstraint(ConstraintFault::UnknownRoles {
        character,
        part,
    })) = &error
    else {
        return Failure::usage(error.to_string());
    };
    Failure::usage(format!(
        "no joint of \"{character}\" has a name that tells its {part}; name one \"{part}\" in the \
         file, or leave out --look-at"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn valid_points_and_reaches_parse_and_others_are_refused() {
        assert_eq!("1, -2.5,3e-1".parse(), Ok(Point([1.0, -2.5, 0.3])));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,NaN", "1,2,inf"] {
            assert!(bad.parse::<Point>().is_err(), "{bad}");
        }
        let reach = ReachArg { joint: "a=b,c".into(), point: Point([0.0, 1.0, 2.0]) };
        assert_eq!(r"a\=b\,c=0,1,2".parse(), Ok(reach));
        for bad in ["hand", "=1,2,3", "hand=1,2", "hand=1,2,3=4"] {
            assert!(bad.parse::<ReachArg>().is_err(), "{bad}");
        }
    }
}
