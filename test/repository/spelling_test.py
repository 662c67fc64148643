"""The words of pages, of the comments in parameters and messages, and of printed texts are in a British
dictionary or in spelling.txt, which holds names and the field's words."""

import os
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from documents_test import REPOSITORY, textOf  # noqa: E402
from words_test import allTexts, prose  # noqa: E402

# A word alone: no part of a name, a path, an address, an option, an escape or a format; without its 's.
WORD = re.compile(r"(?<![\w./:~$%@\\<&=-])[A-Za-z]?[a-z]{2,}(?:'(?!s\b)[a-z]+)?(?![\w/(=:<-]|[.\\]\w)")


def wordsOf(place, text):
    if place.endswith('.md'):
        text = re.sub(r'`[^`]*`|<[a-z/!][^>]*>', '', prose(text))
    elif place.endswith(('.yaml', '.msg', '.srv', '.action')):
        text = '\n'.join(re.findall(r'#(.*)', text))
    elif text.count(' ') < 2 or not place.endswith(('.cpp', '.h', '.py')):
        text = ''  # a name, a format; XML and HTML have more markup than words
    return WORD.findall(text)


def unknown(words):
    done = subprocess.run(['aspell', 'list', '--lang=en_GB', '--encoding=utf-8'], input='\n'.join(sorted(words)),
                          stdout=subprocess.PIPE, universal_newlines=True, check=True)
    return set(done.stdout.split())


@unittest.skipUnless(shutil.which('aspell'), 'aspell is not installed: ./scripts/install_dependencies')
class Spelling(unittest.TestCase):

    def testWordsAreSpeltAsInADictionary(self):
        places = {}
        for place, _, text in allTexts():
            for word in wordsOf(place, text):
                places.setdefault(word, place)
        self.assertGreater(len(places), 2000)
        own = textOf('test', 'repository', 'spelling.txt').split()
        wrong = unknown(places)
        for word in sorted(wrong):
            with self.subTest(word=word, file=places[word]):
                self.assertIn(word.lower(), own, 'correct it, or add it to test/repository/spelling.txt')
        self.assertEqual(own, sorted(set(own)), 'twice or not sorted')
        used = set(re.findall('[a-z]+', ' '.join(places).lower()))
        self.assertEqual(set(own) - used, set(), 'unused')

    def testWhatIsRead(self):
        self.assertEqual(wordsOf('README.md', 'One `two`, README.md and ./four: the robot\'s own.'),
                         ['One', 'and', 'the', 'robot', 'own'])
        self.assertEqual(wordsOf('a.yaml', 'one: 2  # the three\n'), ['the', 'three'])
        self.assertEqual(wordsOf('a.cpp', 'wheels/one is %.1fdeg off'), ['is', 'off'])
        self.assertEqual(unknown({'wheel', 'wheeel', 'colour', 'center'}), {'wheeel', 'center'})


if __name__ == '__main__':
    unittest.main()
