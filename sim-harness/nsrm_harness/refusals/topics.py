"""Words that no domain of blocks has, and sentences that are about something else.

Words and sentences that a domain does know after all are left out when they are used.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

#: In place of an attribute value.
VALUES = (
    "purple", "orange", "brown", "pink", "grey", "golden", "silver", "turquoise", "huge", "tiny",
    "round", "wooden", "heavy", "shiny", "broken", "empty", "striped", "transparent", "second",
)  # fmt: skip
#: In place of a noun.
NOUNS = (
    "ball", "cup", "bottle", "apple", "sofa", "plate", "robot", "table", "box", "sphere",
    "cylinder", "pyramid", "tower", "gripper", "hammer", "spoon", "stack", "key", "lamp",
)  # fmt: skip
#: In place of a verb.
VERBS = (
    "throw", "push", "paint", "eat", "wash", "break", "hide", "rotate", "measure", "describe",
    "count", "weigh", "buy", "forget", "lift", "drop", "find", "photograph", "sell",
)  # fmt: skip

#: Relations that none of the domain's actions has. The last are made of common words.
RELATIONS = (
    "under", "below", "beneath", "underneath", "behind", "in front of", "inside", "in", "into",
    "next to", "beside", "near", "close to", "by", "against", "around", "away from", "far from",
    "across from", "opposite", "through", "past", "towards", "at the foot of", "in the middle of",
    "parallel to", "at the back of", "along", "without", "as far as",
    "to the side of", "on the side of", "to", "of",
)  # fmt: skip
#: A relation between three objects.
BETWEEN = "between"

#: What turns a command into its contrary; the command follows.
PROHIBITIONS = (
    "don't", "do not", "never", "please don't", "please do not", "you must not", "you should not",
    "under no circumstances", "it is forbidden to", "refuse to", "stop before you", "nobody may",
    "avoid it: don't ever", "no , don't", "by no means",
)  # fmt: skip
#: The same, in front of the relation.
EXCLUSIONS = ("not", "anywhere but", "never", "anywhere except")

#: About something else. Some have no word that a robot for blocks does not know.
SENTENCES = (
    "What time is it?",
    "How are you today?",
    "Tell me a joke.",
    "The weather is nice today.",
    "Where is the kitchen?",
    "I would like a cup of coffee.",
    "Open the door, please.",
    "Turn off the lights.",
    "Play some music.",
    "Who won the game last night?",
    "Fly to the moon.",
    "Call my mother.",
    "What is the capital of France?",
    "Set an alarm for seven.",
    "How tall is the tower?",
    "Clean the table.",
    "Charge the battery.",
    "Go home.",
    "Stop.",
    "Wait a minute.",
    "Thank you very much.",
    "Good morning.",
    "Hello robot.",
    "Are you ready?",
    "What do you see?",
    "How many blocks are there?",
    "Which block is the largest?",
    "Is the red block on the blue block?",
    "Why did you move the green block?",
    "Can you reach the white cube?",
    "Describe the scene.",
    "Name all the colors on the table.",
    "Take a picture.",
    "Write a letter to the bank.",
    "Translate this text to Spanish.",
    "Add two and three.",
    "Buy some milk and bread.",
    "Read me the news.",
    "Drive to the airport.",
    "Cook some rice for dinner.",
    "Water the plants every morning.",
    "Feed the cat.",
    "Wash the dishes.",
    "Fold the laundry.",
    "Paint the wall yellow.",
    "The red car is in front of the blue house.",
    "She put her hat on the table.",
    "He moved to the left of the stage.",
    "They placed an order for ten chairs.",
    "My favorite color is magenta.",
    "Once in a blue moon.",
    "The grass is greener on the other side.",
    "Roses are red, violets are blue.",
    "I have a green thumb.",
    "He was caught red handed.",
    "White wine goes well with fish.",
    "The yellow line marks the exit.",
    "A small step for a man.",
    "Lego was founded in Denmark.",
    "Cyan is between green and blue.",
    "Do you like small talk?",
    "The price was set too low.",
    "Put your trust in me.",
    "Put it there.",
    "Put that down.",
    "Move over.",
    "Move on.",
    "Move it.",
    "Set the table.",
    "Lay an egg.",
    "Place your bets.",
    "Take your position.",
    "First things first.",
    "One thing at a time.",
    "One more thing.",
    "Now what?",
    "Now or never.",
    "Please.",
    "Please, now.",
    "Then what?",
    "And then?",
    "And?",
    "Right.",
    "Right now.",
    "To the right.",
    "To the left, to the left.",
    "Left, right, left, right.",
    "On and on and on.",
    "Over and over.",
    "Over and out.",
    "The one on top.",
    "On top of the world.",
    "The one and only.",
    "The thing of the thing.",
    "A block of a block.",
    "Set one on the other.",
    "One cube, then one block.",
    "Red, white and blue.",
    "The red block and the blue block.",
    "One red thing and one blue thing.",
    "Red and green, then yellow and blue.",
    "Green, yellow, red.",
    "Small blue, small red, small green.",
    "The yellow cube, the white cube and the cyan cube.",
    "Move the red block.",
    "Put one thing on the white thing.",
    "Position of the green cube.",
    "The left side of the red block.",
    "Above all, be kind.",
    "Upon my word.",
    "It is what it is.",
    "All is well that ends well.",
    "Nothing to see here.",
    "asdf qwer zxcv",
    "1 2 3 4",
    "42",
    "???",
    "block block block block",
    "the the the the",
    "put put put",
)

#: Made of a beginning and an end, which fit each other well enough.
BEGINNINGS = (
    "What is",
    "Where is",
    "Who made",
    "Tell me about",
    "I dreamt of",
    "Remind me of",
    "How much is",
    "She looked at",
    "Do you remember",
    "Nobody has seen",
    "Let us talk about",
    "Please explain",
    "It all began with",
    "The children drew",
    "Show me",
    "We went to",
    "He sang about",
    "The book is about",
)
ENDS = (
    "the red bicycle",
    "the blue sea",
    "a small village",
    "the green hills",
    "the white house",
    "the yellow submarine",
    "a lego museum",
    "the weather",
    "the block on the corner",
    "the right answer",
    "the left bank",
    "one of the blue birds",
    "my small sister and her red shoes",
    "the cyan and magenta ink",
    "the best place on earth",
    "a position of power",
    "the top of the mountain",
    "a thing of beauty",
)


def other_subjects() -> Iterator[str]:
    """Every sentence about something else."""
    yield from SENTENCES
    for beginning, end in product(BEGINNINGS, ENDS):
        yield f"{beginning} {end}."
