"""scripts/site makes one site of the pages: all of them are in its navigation, its links lead to files
and sections that are there, and each command is shown as code."""

import glob
import html.parser
import os
import re
import shutil
import subprocess
import sys
import unittest
import urllib.parse

import yaml

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from documents_test import DOCUMENTS, REPOSITORY, commandsIn, textOf  # noqa: E402

SITE = os.path.join(REPOSITORY, '.build', 'site', 'html')


def pagesInNavigation():
    text = re.sub(r'!!python\S*( \{.*\}\})?', '', textOf('mkdocs.yml'))
    return re.findall(r'[\w/-]+\.md', yaml.safe_dump(yaml.safe_load(text)['nav']))


class Page(html.parser.HTMLParser):
    """Links, names of sections, code and number of list items of one page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.names, self.code = [], set(), ''
        self.open_blocks, self.in_article, self.items = 0, False, 0
        with open(path, encoding='utf-8') as file:
            self.feed(file.read())

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.names.add(attributes.get('id'))
        self.links += [attributes[key] for key in ('href', 'src') if attributes.get(key)]
        self.open_blocks += tag == 'pre'
        self.in_article |= tag == 'article'
        self.items += tag == 'li' and self.in_article

    def handle_endtag(self, tag):
        self.open_blocks -= tag == 'pre'
        self.in_article &= tag != 'article'

    def handle_data(self, data):
        if self.open_blocks:
            self.code += data


class Navigation(unittest.TestCase):

    def testItLeadsToEveryPage(self):
        pages = {os.path.relpath(path, REPOSITORY) for path in DOCUMENTS} - {'README.md'}
        self.assertEqual(set(pagesInNavigation()), pages | {'index.md'})


@unittest.skipUnless(shutil.which('mkdocs'), 'MkDocs is not installed: ./scripts/install_dependencies --for-site')
class Site(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        done = subprocess.run([os.path.join(REPOSITORY, 'scripts', 'site')], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True, timeout=600)
        assert done.returncode == 0, done.stdout
        cls.pages = {path: Page(path) for path in glob.glob(os.path.join(SITE, '**', '*.html'), recursive=True)}

    def testLinksLeadToFilesAndSections(self):
        found = 0
        for path, page in self.pages.items():
            for link in page.links:
                url = urllib.parse.urlsplit(link)
                # The page for what is not found has absolute links of its own.
                if url.scheme or url.netloc or os.path.basename(path) == '404.html':
                    continue
                target = os.path.normpath(os.path.join(os.path.dirname(path), url.path)) if url.path else path
                found += 1
                with self.subTest(page=os.path.relpath(path, SITE), link=link):
                    self.assertTrue(os.path.isfile(target), 'no such file')
                    if url.fragment and target in self.pages:
                        self.assertIn(urllib.parse.unquote(url.fragment), self.pages[target].names)
        self.assertGreater(found, 1000)

    def builtFrom(self, document):
        name = os.path.relpath(document, REPOSITORY)
        return self.pages[os.path.join(SITE, re.sub(r'(README)?\.md$', lambda end: (
            'index' if end.group(1) else '') + '.html', name))]

    def testListsAreLists(self):
        """Their indentation is one that GitHub and MkDocs read alike."""
        for document in DOCUMENTS:
            text = re.sub(r'(?ms)^ *```.*?^ *```$', '', textOf(document))
            with self.subTest(page=os.path.relpath(document, REPOSITORY)):
                self.assertEqual(self.builtFrom(document).items, len(re.findall(r'(?m)^(?:[-*]|\d+\.) ', text)))

    def testCommandsAreCode(self):
        found = 0
        for document in DOCUMENTS:
            name = os.path.relpath(document, REPOSITORY)
            code = ' '.join(self.builtFrom(document).code.replace('\\\n', ' ').split())
            for command in commandsIn(document):
                found += 1
                with self.subTest(page=name, command=command):
                    self.assertIn(' '.join(command.split()), code)
        self.assertGreater(found, 40)


if __name__ == '__main__':
    unittest.main()
