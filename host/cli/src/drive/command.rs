//! The commands of `foldpath drive`, and how they are written.

use foldpath::stream::Way;

/// Help on the commands, one on each line.
pub(crate) const HELP: &str = "\
watch HINGE                               tell where a hinge stands; nothing moves
jog HINGE to|by DEGREES [from DEGREES]    move a hinge slowly; from says where it stands if nothing measures it
channel HINGE CHANNEL                     give a hinge a channel in the map
zero HINGE                                the hinge is flat where it stands now
sign HINGE +|-                            + if the channel turns with the hinge, - if it turns against it
limits HINGE LOWER UPPER                  smallest and largest angle of a hinge, degrees
show                                      show the map
save                                      write the map
clear                                     leave fault, stop and path behind, and forget where the sheet stands
help                                      show this list
quit                                      end";

/// Names of the commands, for messages.
const NAMES: &str = "watch, jog, channel, zero, sign, limits, show, save, clear, help or quit";

/// A command. Angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Command {
    Watch(u16),
    /// Hinge, way, and where the hinge stands by the word of an operator.
    Jog(u16, Turn, Option<f64>),
    Channel(u16, u16),
    Zero(u16),
    /// Hinge, and `true` if its channel turns against it.
    Sign(u16, bool),
    Limits(u16, [f64; 2]),
    Show,
    Save,
    Clear,
    Help,
    Quit,
}

/// Angle to which a hinge is moved, or by which, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Turn {
    To(f64),
    By(f64),
}

/// Converts an angle to radians as a controller has them.
#[allow(clippy::cast_possible_truncation, reason = "rounds an angle")]
pub(crate) fn radians(degrees: f64) -> f32 {
    degrees.to_radians() as f32
}

impl Turn {
    pub(crate) fn way(self) -> Way {
        match self {
            Self::To(degrees) => Way::To(radians(degrees)),
            Self::By(degrees) => Way::By(radians(degrees)),
        }
    }
}

/// Reads commands one after the other.
///
/// # Errors
/// If a word is not what was expected; the error names both.
pub(crate) fn parse(text: &str) -> Result<Vec<(Command, String)>, String> {
    let mut words = Words {
        words: text.split_whitespace().peekable(),
        read: Vec::new(),
    };
    let mut commands = Vec::new();
    while words.words.peek().is_some() {
        let command = words.command()?;
        commands.push((command, words.read.join(" ")));
        words.read.clear();
    }
    Ok(commands)
}

/// Words to read, and those of the present command that were read.
struct Words<'a, I: Iterator<Item = &'a str>> {
    words: core::iter::Peekable<I>,
    read: Vec<&'a str>,
}

impl<'a, I: Iterator<Item = &'a str>> Words<'a, I> {
    fn command(&mut self) -> Result<Command, String> {
        let (found, name) = self.next(&format!("a command ({NAMES})"))?;
        Ok(match name {
            "watch" => Command::Watch(self.hinge()?),
            "jog" => {
                let hinge = self.hinge()?;
                let turn = match self.next("to or by")? {
                    (_, "to") => Turn::To(self.degrees()?),
                    (_, "by") => Turn::By(self.degrees()?),
                    (wrong, _) => return Err(wrong),
                };
                let from = self.words.next_if_eq(&"from");
                let from = from.map(|from| {
                    self.read.push(from);
                    self.degrees()
                });
                Command::Jog(hinge, turn, from.transpose()?)
            }
            "channel" => Command::Channel(self.hinge()?, self.whole("a channel, 0 to 65535")?),
            "zero" => Command::Zero(self.hinge()?),
            "sign" => {
                let hinge = self.hinge()?;
                match self.next("+ or -")? {
                    (_, "+") => Command::Sign(hinge, false),
                    (_, "-") => Command::Sign(hinge, true),
                    (wrong, _) => return Err(wrong),
                }
            }
            "limits" => {
                let hinge = self.hinge()?;
                let lower = self.degrees()?;
                let expected = format!("a number of degrees from {lower} on");
                let (wrong, word) = self.next(&expected)?;
                let upper = number(word).filter(|upper| *upper >= lower);
                Command::Limits(hinge, [lower, upper.ok_or(wrong)?])
            }
            "show" => Command::Show,
            "save" => Command::Save,
            "clear" => Command::Clear,
            "help" => Command::Help,
            "quit" => Command::Quit,
            _ => return Err(found),
        })
    }

    /// Returns the next word, and the error if it is not what was expected.
    fn next(&mut self, expected: &str) -> Result<(String, &'a str), String> {
        let before = self.read.join(" ");
        let place = if before.is_empty() {
            String::new()
        } else {
            format!("{before}: ")
        };
        let wrong = |found: &str| format!("{place}expected {expected}, found {found}");
        let Some(word) = self.words.next() else {
            return Err(wrong("nothing"));
        };
        self.read.push(word);
        Ok((wrong(word), word))
    }

    fn whole(&mut self, expected: &str) -> Result<u16, String> {
        let (wrong, word) = self.next(expected)?;
        word.parse().map_err(|_| wrong)
    }

    fn hinge(&mut self) -> Result<u16, String> {
        self.whole("the number of a hinge")
    }

    fn degrees(&mut self) -> Result<f64, String> {
        let (wrong, word) = self.next("a number of degrees")?;
        number(word).ok_or(wrong)
    }
}

fn number(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_follow_one_another() {
        let text = "watch 3 jog 3 to -10.5 jog 4 by 5 from 0 channel 3 7 zero 3 sign 3 - sign 4 +\n limits 3 -90 0 show \
                    save clear help quit";
        let commands: Vec<Command> = parse(text).unwrap().iter().map(|pair| pair.0).collect();
        assert_eq!(
            commands,
            [
                Command::Watch(3),
                Command::Jog(3, Turn::To(-10.5), None),
                Command::Jog(4, Turn::By(5.0), Some(0.0)),
                Command::Channel(3, 7),
                Command::Zero(3),
                Command::Sign(3, true),
                Command::Sign(4, false),
                Command::Limits(3, [-90.0, 0.0]),
                Command::Show,
                Command::Save,
                Command::Clear,
                Command::Help,
                Command::Quit,
            ]
        );
        assert_eq!(parse(text).unwrap()[2].1, "jog 4 by 5 from 0");
        assert_eq!(parse(" "), Ok(Vec::new()));
    }

    #[test]
    fn a_wrong_word_is_named_with_what_was_expected() {
        for (text, message) in [
            ("jgo 3", "expected a command (watch, jog, "),
            (
                "watch",
                "watch: expected the number of a hinge, found nothing",
            ),
            (
                "watch -1",
                "watch: expected the number of a hinge, found -1",
            ),
            ("jog 3 at 5", "jog 3: expected to or by, found at"),
            (
                "jog 3 to up",
                "jog 3 to: expected a number of degrees, found up",
            ),
            (
                "jog 3 to inf",
                "jog 3 to: expected a number of degrees, found inf",
            ),
            (
                "jog 3 to 5 from",
                "jog 3 to 5 from: expected a number of degrees, found nothing",
            ),
            (
                "channel 3 70000",
                "channel 3: expected a channel, 0 to 65535, found 70000",
            ),
            ("sign 3 up", "sign 3: expected + or -, found up"),
            (
                "limits 3 10 5",
                "limits 3 10: expected a number of degrees from 10 on, found 5",
            ),
            ("show 3", "expected a command (watch, jog, "),
        ] {
            let found = parse(text).unwrap_err();
            assert!(found.starts_with(message), "{found}");
        }
    }
}
