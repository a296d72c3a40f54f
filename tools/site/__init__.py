"""Build the web site of vidstyle: `python -m tools.site [FOLDER]`.

The site has the documents with search, a page for each style and block, the commands, the API reference, and
the page on which visitors restyle their own pictures. It loads nothing from other hosts. All texts come from
the documents, the declarations of blocks and options, and the styles.
"""
